"""The network to adjust: frozen arrays, free of files, units and user's spelling.

Everything is in the inner units: millimetres in the photo, metres in the local object frame (user coordinates
minus :attr:`Network.origin`), radians.  Indices replace ids; ``*_ids`` give the ids back for people.

A standard deviation of 0 means *fixed* (the unknown is removed), infinity means *free* (no prior).
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.settings import LocalTesting, OutlierPolicy, WeightPolicy

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

RotationSequence = Literal["omega-phi-kappa", "phi-omega-kappa"]
Role = Literal["control", "partial", "tie", "check"]
Datum = Literal["control", "minimal", "inner"]


@dataclass(frozen=True)
class Camera:
    """Interior orientation: principal distance, principal point, Brown distortion, affinity.

    The correction is applied to the *measured* photo coordinates (backward model), see
    :mod:`splinebba_cli.core.camera.distortion`.
    """

    id: str
    principal_distance_mm: float
    principal_point_mm: FloatArray  # (2,)
    radial: FloatArray  # (3,) K1, K2, K3 in mm^-2, mm^-4, mm^-6
    decentring: FloatArray  # (2,) P1, P2 in mm^-1
    affinity: FloatArray  # (2,) b1 (scale of x), b2 (shear), without unit
    pixel_size_mm: float | None = None
    format_mm: tuple[float, float] | None = None  # width, height; for footprints and plots


@dataclass(frozen=True)
class Images:
    """Exterior orientations; one row an image.

    ``rotation`` is R (object from photo); rows of ``rotation`` and ``position`` are NaN where the user gives no
    approximate orientation.  Priors are on (omega, phi, kappa, X0, Y0, Z0): radians, metres (local).
    """

    ids: tuple[str, ...]
    camera: IntArray  # (m,)
    rotation: FloatArray  # (m, 3, 3)
    position: FloatArray  # (m, 3)
    sequence: tuple[RotationSequence, ...]  # (m,)
    prior: FloatArray  # (m, 6), NaN where sigma is infinite
    prior_sigma: FloatArray  # (m, 6), 0 = fixed, inf = free

    @cached_property
    def sequences(self) -> tuple[RotationSequence, ...]:
        """The rotation sequences that occur."""
        return tuple(sorted(set(self.sequence)))

    @property
    def has_orientation(self) -> BoolArray:
        """Whether an approximate orientation is given, (m,)."""
        return np.asarray(
            np.isfinite(self.position).all(axis=1) & np.isfinite(self.rotation).all(axis=(1, 2))
        )


@dataclass(frozen=True)
class Points:
    """Object points: control, tie and check points; one row a point."""

    ids: tuple[str, ...]
    role: tuple[Role, ...]
    xyz: FloatArray  # (n, 3) approximate or given coordinates, NaN where unknown
    sigma: FloatArray  # (n, 3) prior sigma: 0 fixed, inf free (ties and checks are inf)
    check_sigma: FloatArray  # (n, 3) sigma of the given coordinates of check points, else NaN


@dataclass(frozen=True)
class Curve:
    """One linear feature by the values people give: rows of three numbers.

    What a row of ``values`` is belongs to the family: a knot for natural and cardinal splines, a control point for
    B-splines, an end point for a straight line, the coefficient vector of one power of t (Lee's a0..a3 of every
    segment) for polynomials, the centre and the vectors of cos and sin for conics and Fourier curves.
    """

    id: str
    role: Role
    family: str  # a name registered in core.curves.registry
    values: FloatArray  # (k, 3) approximate (or given) values
    sigma: FloatArray  # (k, 3) prior sigma of the values: 0 fixed (held), inf free
    closed: bool = False
    knot_parameters: FloatArray | None = (
        None  # one more than segments; None: by `parameterization`; conic: the arc
    )
    parameterization: Literal["uniform", "chord_length"] = "chord_length"
    breaks: tuple[int, ...] = ()  # knots at which the curve has a corner (C0)
    reference: FloatArray | None = None  # (k, 3) reference values of the gauge conditions; None: `values`
    check_values: FloatArray | None = None  # (q, 3) given shape of a check spline (points along it)
    check_sigma: float = 0.0  # m, of these points in every direction across
    continuity: int = -1  # of the segments of a polynomial: -1 none, 0 C0, 1 C1, 2 C2
    natural_ends: bool = False  # X'' = 0 at both ends of a C2 polynomial of degree 3
    tension: float = 0.0  # of a cardinal spline, [-1, 1); 0: Catmull-Rom


@dataclass(frozen=True)
class CurveObservations:
    """Image points measured on curves; every one brings its own location along the curve."""

    image: IntArray  # (n,)
    curve: IntArray  # (n,)
    photo_xy: FloatArray  # (n, 2) mm, as measured (principal point and distortion not applied)
    sigma: FloatArray  # (n, 2) mm
    location: FloatArray  # (n,) approximate u, NaN where unknown
    segment: IntArray  # (n,) segment to which u is restricted, -1 where it is not
    group: IntArray | None = None  # (n,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (n,) rows that the user has taken out, None: none

    def __len__(self) -> int:
        return len(self.image)


@dataclass(frozen=True)
class UnlabelledPoints:
    """Image points on edges that nobody has assigned to a curve: they take no part before they are matched.

    Points of a chain (a traced polyline of one image) follow each other in the order of tracing.
    """

    image: IntArray  # (n,)
    photo_xy: FloatArray  # (n, 2) mm, as measured
    sigma: FloatArray  # (n, 2) mm
    chain: IntArray  # (n,) index into chain_ids, -1: a single point
    direction: (
        FloatArray  # (n,) rad, of the edge, from x towards y of the photo, up to half a turn; NaN unknown
    )
    chain_ids: tuple[str, ...] = ()
    group: IntArray | None = None  # (n,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (n,) rows that the user has taken out, None: none

    def __len__(self) -> int:
        return len(self.image)

    @classmethod
    def none(cls) -> UnlabelledPoints:
        """No unlabelled points."""
        whole, two = _no_indices(), np.zeros((0, 2))
        return cls(whole, two, two, whole, np.zeros(0))


@dataclass(frozen=True)
class PointObservations:
    """Image points of object points."""

    image: IntArray  # (n,)
    point: IntArray  # (n,)
    photo_xy: FloatArray  # (n, 2) mm, as measured
    sigma: FloatArray  # (n, 2) mm
    group: IntArray | None = None  # (n,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (n,) rows that the user has taken out, None: none

    def __len__(self) -> int:
        return len(self.image)


@dataclass(frozen=True)
class ArcLengths:
    """Lengths of projected curves in the image, between two measured points of one image and one curve (Lee 3.4).

    A measured point may end one arc and begin another, so that arcs make chains.
    """

    first: IntArray  # (q,) measured curve points
    second: IntArray  # (q,)
    length: FloatArray  # (q,) mm, as measured
    sigma: FloatArray  # (q,) mm
    simpson: BoolArray  # (q,) one Simpson step (Lee 3.38), else Gauss-Legendre, split at joints
    group: IntArray | None = None  # (q,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (q,) rows that the user has taken out, None: none

    def __len__(self) -> int:
        return len(self.first)

    @classmethod
    def none(cls) -> ArcLengths:
        """No arc lengths."""
        return cls(_no_indices(), _no_indices(), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))


@dataclass(frozen=True)
class Tangents:
    """Directions of projected curves in the image, at measured points; at most one a point (Lee 3.5)."""

    point: IntArray  # (q,) measured curve point
    direction: FloatArray  # (q,) rad, from the x axis of the photo frame towards its y axis, as measured
    sigma: FloatArray  # (q,) rad
    directed: BoolArray  # (q,) has the sense of ascending locations; else known up to half a turn
    group: IntArray | None = None  # (q,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (q,) rows that the user has taken out, None: none

    def __len__(self) -> int:
        return len(self.point)

    @classmethod
    def none(cls) -> Tangents:
        """No tangents."""
        return cls(_no_indices(), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))


@dataclass(frozen=True)
class Distances:
    """Lengths in the object between two stations: scale bars between points, bases between perspective centres."""

    station: IntArray  # (q, 2) number of the object point or of the image at either end
    is_image: BoolArray  # (q, 2) whether an end is a perspective centre
    length: FloatArray  # (q,) metres, as measured
    sigma: FloatArray  # (q,) metres
    group: IntArray | None = None  # (q,) index into group_names, None: one group
    group_names: tuple[str, ...] = ()
    excluded: BoolArray | None = None  # (q,) taken out by the user, None: none is

    def __len__(self) -> int:
        return len(self.length)

    @classmethod
    def none(cls) -> Distances:
        """No distances."""
        return cls(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2), dtype=bool), np.zeros(0), np.zeros(0))


@dataclass(frozen=True)
class DatumFeatures:
    """Over which coordinates the inner constraints of a free network run; None: all of them that are free."""

    points: tuple[str, ...] | None = None
    images: tuple[str, ...] | None = ()
    curves: tuple[str, ...] | None = ()


Observed = TypeVar(
    "Observed", PointObservations, CurveObservations, ArcLengths, Tangents, Distances, UnlabelledPoints
)


def select_rows(observed: Observed, rows: IntArray) -> Observed:
    """Some observations of one kind: all its arrays that have one entry an observation."""
    arrays: dict[str, Any] = {
        each.name: value[rows]
        for each in fields(observed)
        if isinstance(value := getattr(observed, each.name), np.ndarray)
    }
    return replace(observed, **arrays)


def _no_indices() -> IntArray:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class KnotPolicy:
    """What the program may do with the knots of tie splines (theory: knots follow need)."""

    spacing_m: float | None = None  # re-space knots to about this distance of equal arc length; None: keep
    insert: bool = False  # insert knots where residuals along the curve are systematic
    drop: bool = False  # drop knots that no measurement supports


@dataclass(frozen=True)
class Settings:
    """How to adjust."""

    datum: Datum = "control"
    datum_features: DatumFeatures | None = (
        None  # of the datum "inner"; None: points, or images where there are few
    )
    sigma0_prior: float = 1.0
    alpha: float = 0.05
    max_iterations: int = 50
    gauge_sigma_m: float | None = None  # None: a share of the mean knot distance, by family
    gauge_conditions: Literal["needed", "all"] = "needed"  # which stay in the last solution
    scale_dispersion: bool = True  # multiply the dispersion by the estimated variance of unit weight
    staged: bool = True  # orientation from points first, then curves, then all together
    knots: KnotPolicy = field(default_factory=KnotPolicy)
    testing: LocalTesting = field(default_factory=LocalTesting)
    outliers: OutlierPolicy = field(default_factory=OutlierPolicy)
    weights: WeightPolicy = field(default_factory=WeightPolicy)
    confidence: float = 0.95  # of confidence ellipses and intervals
    correlation_threshold: float = 0.95  # beyond which a correlation is named


@dataclass(frozen=True)
class Network:
    """All that is adjusted together."""

    origin: FloatArray  # (3,) user coordinates of the local origin, metres
    cameras: tuple[Camera, ...]
    images: Images
    points: Points
    curves: tuple[Curve, ...]
    point_observations: PointObservations
    curve_observations: CurveObservations
    settings: Settings = field(default_factory=Settings)
    arc_lengths: ArcLengths = field(default_factory=ArcLengths.none)
    tangents: Tangents = field(default_factory=Tangents.none)
    distances: Distances = field(default_factory=Distances.none)
    unlabelled: UnlabelledPoints = field(default_factory=UnlabelledPoints.none)
