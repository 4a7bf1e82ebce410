"""What the quality control found: plain data, in the units of the observations that it is about."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.settings import Multiplicity, TestStatistic

ObservationKind = Literal[
    "point", "spline", "arc length", "tangent", "distance",
    "control point", "control spline", "eop prior",
]  # fmt: skip


@dataclass(frozen=True)
class LocalTests:
    """Significance and power that all local tests share."""

    statistic: TestStatistic
    alpha: float  # as the user gives it: of one test, or of all of them together
    multiplicity: Multiplicity
    alpha_single: float  # of one test
    power: float
    tests: int  # number of tested observations
    critical: float  # of |w| or |tau|
    noncentrality: float  # delta0(alpha, beta): an MDB moves w by this
    beyond: int  # observations beyond the critical value


@dataclass(frozen=True)
class Reliability:
    """What an error of an observation must be to be found, and what it does while it is not; inf: never found."""

    minimal_detectable_bias: FloatArray  # unit of the observation; NaN where nothing is observed
    bias_to_noise: FloatArray  # effect of an MDB on any function of the unknowns in its sigmas, at most
    orientation_influence: FloatArray  # effect of an MDB on the orientation of its image in sigmas, at most


@dataclass(frozen=True)
class Influence:
    """An observation whose undetected error does much harm (external reliability): the effects of one MDB."""

    kind: ObservationKind
    name: str  # "image `3` on spline `road`, across"
    redundancy: float
    minimal_detectable_bias: float  # in `unit`
    unit: Literal["mm", "rad", "m"]
    bias_to_noise: float  # delta0 sqrt((1 - r) / r)
    orientation: float  # largest effect on the orientation of an image, in its sigmas
    orientation_image: str  # of which image
    position_m: float  # largest effect on a perspective centre
    position_image: str
    angle_rad: float  # largest effect on an attitude
    angle_image: str
    object_m: float  # largest effect on a point, or on a knot across its curve
    object_name: str  # "point `p12`", "spline `road`"


@dataclass(frozen=True)
class GroupTest:
    """Test of a whole group of observations against one common error."""

    kind: Literal["chain", "control spline", "control point"]
    name: str  # "image `3` on spline `road`"
    model: str  # "shift across", "shift (3)"
    observations: int
    parameters: int
    estimate: FloatArray  # (parameters,) estimated common error; mm or m
    sigma: FloatArray  # (parameters,)
    unit: Literal["mm", "m"]
    statistic: float  # chi-square of `parameters` degrees of freedom
    critical: float
    passed: bool
    minimal_detectable: float  # smallest detectable common error in its best determined direction; mm or m
    probability: float = 1.0  # that any of all groups has a statistic at least as large without an error


@dataclass(frozen=True)
class Rejection:
    """One decision of the outlier search; a returned observation stays in the log."""

    kind: ObservationKind
    row: int  # of the observations of its kind, in the project's order
    name: str
    round: int
    reason: str  # "w = 6.1 beyond 3.29", "weight 0.003 of tukey"
    statistic: float  # w or tau when it was rejected
    predicted: float  # w of the rejected observation against the last solution
    residual: float  # mm, rad or m: adjusted - measured, not taking part
    returned: bool = False


@dataclass(frozen=True)
class Revision:
    """What the outlier search did; factors of the weights are 1 where nothing was done, 0 where rejected."""

    method: str = "none"
    start: str = "least_squares"
    rounds: int = 0
    rejections: tuple[Rejection, ...] = ()
    point_weights: FloatArray | None = None  # (n,) factors of the weights; None: all 1
    curve_weights: FloatArray | None = None
    arc_weights: FloatArray | None = None
    tangent_weights: FloatArray | None = None
    distance_weights: FloatArray | None = None

    @property
    def rejected(self) -> int:
        """Number of observations that take no part."""
        return sum(not rejection.returned for rejection in self.rejections)


@dataclass(frozen=True)
class VarianceComponent:
    """Variance of unit weight of one group of observations (Foerstner 1979; Helmert)."""

    group: str
    kind: ObservationKind
    observations: int
    redundancy: float  # sum of redundancy numbers
    sigma0: float  # a posteriori over a priori sigma of the group, with the weights used; NaN: nothing is left over
    sigma0_sigma: float  # its own standard deviation
    factor: float  # by which the given sigma of the group was multiplied in this adjustment
    statistic: float  # chi-square of `freedom` degrees
    lower: float
    upper: float
    passed: bool
    freedom: float = 0.0  # equivalent degrees of freedom of the estimate, at most the redundancy
    estimated: bool = False  # whether the factor was estimated, not left at 1


@dataclass(frozen=True)
class SystematicEffect:
    """One test for an effect that single residuals do not show."""

    kind: Literal[
        "image mean", "radial trend", "tangential trend", "grid", "run along curve", "drift", "strip"
    ]
    subject: str  # "image `3`", "camera `cam`", "spline `road`"
    estimate: float  # in `unit`
    unit: str
    statistic: float
    critical: float
    significant: bool
    observations: int
    detail: str = ""
    shown: float = (
        1.0  # share of such an effect that residuals show (whitened norm); unknowns take up the rest
    )
    probability: float = (
        1.0  # that any test of its family has a statistic at least as large without an effect
    )


@dataclass(frozen=True)
class ResidualGrid:
    """Mean residual vectors in the cells of the image format, over all images of a camera; mm."""

    camera: str
    x_edges: FloatArray  # (nx + 1,)
    y_edges: FloatArray  # (ny + 1,)
    mean: FloatArray  # (ny, nx, 2), NaN where a cell is not determined
    sigma: FloatArray  # (ny, nx, 2)
    count: FloatArray  # (ny, nx)


@dataclass(frozen=True)
class HighCorrelation:
    """Two unknowns that are determined together only."""

    first: str
    second: str
    correlation: float


@dataclass(frozen=True)
class ErrorEllipses:
    """Standard ellipses and ellipsoids of positions and their uncertainty with a confidence, one row a position."""

    ids: tuple[str, ...]
    semi_axes_m: FloatArray  # (n, 2) horizontal standard ellipse, larger first
    azimuth_rad: FloatArray  # (n,) of its larger axis, from the Y axis of the object frame clockwise, [0, pi)
    ellipsoid_m: FloatArray  # (n, 3) semi-axes of the standard ellipsoid, larger first
    ellipsoid_axes: FloatArray  # (n, 3, 3) their unit directions, one a row
    horizontal_m: (
        FloatArray  # (n,) radius of the circle that holds the horizontal position with the confidence
    )
    vertical_m: FloatArray  # (n,) half length of the vertical interval with the confidence

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True)
class Precision:
    """Precision of positions with a confidence, and what is correlated."""

    confidence: float
    degrees: float | None  # redundancy from which the variance of unit weight is estimated; None: it is known
    interval_factor: float  # of standard deviations, for an interval with the confidence
    ellipse_factor: float  # of standard ellipses, horizontal ones and those across curves
    ellipsoid_factor: float
    images: ErrorEllipses
    points: ErrorEllipses
    correlations: tuple[HighCorrelation, ...] = ()  # the highest ones
    correlations_found: int = 0  # beyond the threshold, listed or not
    correlation_threshold: float = 0.95


CriterionStatus = Literal["passed", "failed", "untested"]


@dataclass(frozen=True)
class Criterion:
    """One acceptance criterion of the project, with what was found."""

    key: str  # of `acceptance` in the project: "max_sigma0"
    title: str  # "largest σ of a perspective centre"
    value: float | None  # None: there is none to test
    limit: float | None  # None: a test, passed or not
    unit: str  # "m", "°", ""
    status: CriterionStatus
    message: str  # one sentence: what was found against what is allowed
    subject: str = ""  # the worst one: "image `762`"


@dataclass(frozen=True)
class Evidence:
    """All of it."""

    tests: LocalTests | None = None
    influences: tuple[Influence, ...] = ()
    groups: tuple[GroupTest, ...] = ()
    possible_groups: int = 0  # of which those with the largest mean residuals were tested
    variance_components: tuple[VarianceComponent, ...] = ()
    systematic: tuple[SystematicEffect, ...] = ()
    grids: tuple[ResidualGrid, ...] = ()
    precision: Precision | None = None
