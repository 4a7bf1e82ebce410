"""What an adjustment gives back: plain data, metres and radians in the user's object frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from splinebba_cli.core.evidence import Criterion, Evidence, Reliability, Revision
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.prior_residuals import PriorResiduals

Severity = Literal["error", "warning", "info"]


@dataclass(frozen=True)
class Problem:
    """Something a person should know, before the figures: code, what, about whom, and what would cure it."""

    code: str  # "SBB501"
    severity: Severity
    message: str
    subject: str  # "image `762`", "spline `coast-3`", "adjustment"
    help: str = ""


@dataclass(frozen=True)
class GlobalTest:
    """Two-sided chi-square test of r sigma0^2 / sigma0_prior^2 (Lee 4.6)."""

    statistic: float
    lower: float
    upper: float
    alpha: float
    passed: bool


@dataclass(frozen=True)
class Statistics:
    """Counts and variance of unit weight.  redundancy = observations + conditions - unknowns."""

    observations: int  # scalar: image coordinates, arc lengths, tangents, control and prior equations
    unknowns: int  # locations included
    conditions: int  # gauge, shape and datum conditions
    rank_defect: int  # of the measurements and priors alone
    redundancy: int
    sum_redundancy_numbers: float  # equals redundancy: a built-in check
    condition_redundancy: float  # part of the redundancy numbers that belongs to the conditions
    condition_cost: float  # part of v'Pv that the conditions take
    vtpv: float
    sigma0_prior: float
    sigma0: float  # a posteriori; NaN when redundancy is 0
    global_test: GlobalTest | None  # None when redundancy is 0


@dataclass(frozen=True)
class Iteration:
    """One line of the convergence log."""

    stage: str  # "points", "curves", "joint"
    number: int
    cost: float  # v'Pv
    step: float  # largest step in units of the predicted sigma
    damping: float


@dataclass(frozen=True)
class ImageResult:
    """Adjusted exterior orientations; order omega, phi, kappa, X0, Y0, Z0 (rad, m)."""

    eop: FloatArray  # (m, 6) user frame
    rotation: FloatArray  # (m, 3, 3)
    dispersion: FloatArray  # (m, 6, 6), of eop; zero rows where fixed
    estimated: BoolArray  # (m, 6)


@dataclass(frozen=True)
class SegmentCoefficients:
    """Lee's a, b, c of every segment for t in [0, 1]; none of trigonometric families."""

    interval: FloatArray  # (s, 2) knot parameters
    coefficients: FloatArray  # (s, 4, 3): power, coordinate
    sigma: FloatArray  # (s, 4, 3)


@dataclass(frozen=True)
class ConicElements:
    """Geometry of a conic or circle: C + A cos u + B sin u, whatever the phase of u."""

    centre: FloatArray  # (3,) user frame
    semi_axes: FloatArray  # (2,) m, larger first
    axes: FloatArray  # (2, 3) their unit directions
    normal: FloatArray  # (3,) unit normal of the plane, upwards
    eccentricity: float
    form: str  # "circle", "ellipse" (Lee, table 4.1)
    centre_sigma: FloatArray  # (3,) m
    semi_axes_sigma: FloatArray  # (2,) m
    eccentricity_sigma: float  # 0 of a circle; NaN where an adjusted ellipse is round
    normal_sigma_rad: float  # larger semi-axis of the standard ellipse of the normal's direction


@dataclass(frozen=True)
class Ellipse:
    """The ellipse nearest to a closed curve: any family in comparable terms."""

    centre: FloatArray  # (3,) user frame
    semi_axes: FloatArray  # (2,) m, larger first
    normal: FloatArray  # (3,) unit, upwards
    rms_m: float  # distance of the curve from it
    largest_m: float


@dataclass(frozen=True)
class CurveResult:
    """One adjusted curve."""

    values: (
        FloatArray  # (k, 3) knots (or the family's values), user frame; vectors among them are not shifted
    )
    values_dispersion: FloatArray  # (k, 3, 3) of each value
    knots: FloatArray  # (q, 3) the curve at its knot parameters
    knot_parameters: FloatArray  # (q,)
    knot_sigma: FloatArray  # (q, 3)
    reference: FloatArray  # (k, 3) reference values of the gauge conditions, user frame
    segments: SegmentCoefficients
    sample_u: FloatArray  # (p,) samples along the curve for figures and precision
    sample_xyz: FloatArray  # (p, 3) user frame
    sample_across: FloatArray  # (p, 2) semi-axes of the lateral standard ellipse, m, larger first
    sample_across_direction: FloatArray  # (p, 3) unit direction of the larger semi-axis, object frame
    sigma_across_max: float
    sigma_across_mean: float
    rms_across_mm: float  # residuals across the curve, photo
    n_observations: int
    n_images: int
    along_sigma: FloatArray  # (q,) sigma of the knots along the curve: datum-dependent
    conic: ConicElements | None = None  # of conics and circles
    ellipse: Ellipse | None = None  # of closed curves


@dataclass(frozen=True)
class PointResult:
    """Adjusted object points."""

    xyz: FloatArray  # (n, 3) user frame
    dispersion: FloatArray  # (n, 3, 3)
    rays: IntArray  # (n,)


@dataclass(frozen=True)
class ResidualTable:
    """Residuals v = adjusted - measured of image points, mm in the measured photo frame, one row an image point."""

    residual: FloatArray  # (n, 2)
    across: FloatArray  # (n,) residual across the curve (points: NaN)
    redundancy: (
        FloatArray  # (n, 2) redundancy numbers in x and y (curves: across in the first, 0 in the second)
    )
    standardized: FloatArray  # (n, 2) v / (sigma0_prior sqrt(q_vv)); curves: across first, NaN second
    location: FloatArray  # (n,) u (points: NaN)
    normal: FloatArray  # (n, 2) unit normal of the projected curve (points: NaN)
    location_sigma: FloatArray  # (n,) of u, 0 where it is held (points: NaN): datum-dependent
    reliability: Reliability  # (n, 2) each, as `standardized`; mm


@dataclass(frozen=True)
class ScalarResiduals:
    """Residuals v = adjusted - measured: arc lengths (mm), tangents (rad) as measured in the photo, distances (m)."""

    residual: FloatArray  # (q,)
    sigma: FloatArray  # (q,)
    redundancy: FloatArray  # (q,) redundancy numbers
    standardized: FloatArray  # (q,) v / (sigma0_prior sqrt(q_vv))
    reliability: Reliability  # (q,) each

    @classmethod
    def none(cls) -> ScalarResiduals:
        """No observations of a kind."""
        none = np.zeros(0)
        return cls(none, none, none, none, Reliability(none, none, none))


@dataclass(frozen=True)
class CheckTest:
    """Differences against their predicted dispersion: d'C^-1 d and the largest value that is accepted."""

    statistic: float
    degrees: float  # of freedom of the statistic
    critical: float
    passed: bool


@dataclass(frozen=True)
class CheckPoint:
    """Difference adjusted - given of a check point."""

    id: str
    difference: FloatArray  # (3,)
    sigma: FloatArray  # (3,) predicted sigma of the difference
    normalized: float  # sqrt(d' Q^-1 d / 3)
    passed: bool = True  # the test of this point alone


@dataclass(frozen=True)
class CheckPointSummary:
    """All check points together; metres.  Accuracies include that of the given coordinates (ASPRS 2023)."""

    count: int
    rmse: FloatArray  # (3,)
    mean: FloatArray  # (3,)
    largest: FloatArray  # (3,) difference of largest amount, with its sign
    rmse_horizontal: float  # sqrt(rmse_x^2 + rmse_y^2)
    rmse_vertical: float
    given_horizontal: float  # accuracy of the given coordinates, root mean square of their sigma
    given_vertical: float
    accuracy_horizontal: float
    accuracy_vertical: float
    accuracy_3d: float
    alpha: float  # of all single tests together, of the test together and of that of the mean
    critical: float  # of sqrt(d' Q^-1 d / 3) of one point
    beyond: int  # points whose test fails
    together: CheckTest | None  # all differences with their correlations; None: too many for it
    shift: CheckTest | None  # their mean


@dataclass(frozen=True)
class CheckSpline:
    """Distance across, adjusted curve to the given shape, at the given points."""

    id: str
    distance: FloatArray  # (q,) normal to the curve, m; NaN beyond an end of an open curve
    rms: float
    largest: float
    sigma_mean: float
    mean: float = float("nan")  # of the distances
    shift: FloatArray = field(
        default_factory=lambda: np.full(3, np.nan)
    )  # (3,) mean adjusted - given, across
    normalized: FloatArray = field(default_factory=lambda: np.zeros(0))  # (q,) sqrt(d' C^-1 d / 2)
    critical: float = float("nan")  # of the normalized distance at one point
    beyond: int = 0  # points whose test fails
    together: CheckTest | None = None  # all of its points, with their correlations


@dataclass(frozen=True)
class Checks:
    """Check points and check splines against what was given for them."""

    points: tuple[CheckPoint, ...] = ()
    splines: tuple[CheckSpline, ...] = ()
    summary: CheckPointSummary | None = None  # of the check points


@dataclass(frozen=True)
class DispersionBlocks:
    """Covariances of the parameters that people use, with names of rows."""

    names: tuple[str, ...]  # (N,) "image 762 omega", ... in units of `unit`
    matrix: FloatArray | None  # (N, N) full, only on request


@dataclass(frozen=True)
class AdjustmentResult:
    """Everything that an adjustment found."""

    network: Network  # as adjusted: knots may have been re-spaced, inserted or dropped
    converged: bool
    termination: str  # "step negligible", ...
    iterations: tuple[Iteration, ...]
    statistics: Statistics
    images: ImageResult
    curves: Sequence[CurveResult]
    points: PointResult
    point_residuals: ResidualTable
    curve_residuals: ResidualTable
    prior_residuals: PriorResiduals
    checks: Checks
    problems: tuple[Problem, ...]
    dispersion: DispersionBlocks | None = None
    arc_residuals: ScalarResiduals = field(default_factory=ScalarResiduals.none)
    tangent_residuals: ScalarResiduals = field(default_factory=ScalarResiduals.none)
    distance_residuals: ScalarResiduals = field(default_factory=ScalarResiduals.none)
    evidence: Evidence = field(default_factory=Evidence)
    revision: Revision = field(default_factory=Revision)
    acceptance: tuple[Criterion, ...] = ()  # criteria of the project, once they are assessed
    timings: dict[str, float] = field(default_factory=dict)
