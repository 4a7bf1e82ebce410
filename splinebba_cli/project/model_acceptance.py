"""What a result must satisfy."""

from __future__ import annotations

from pydantic import Field

from splinebba_cli.project.scalars import Model, NonNegativeNumber, PositiveNumber


class Acceptance(Model):
    """What a result must satisfy; a criterion that fails, or has nothing to test, ends `adjust` with exit code 1."""

    global_test: bool = Field(
        default=False,
        description="The χ² test of the variance of unit weight must pass; where weights are reduced "
        "(`adjustment.outliers`), its upper bound only.",
    )
    max_sigma0: PositiveNumber | None = Field(
        default=None, description="Largest σ̂₀ (in units of sigma0_prior's unit weight)."
    )
    max_standardized: PositiveNumber | None = Field(
        default=None,
        description="Largest standardised residual |w|, or |τ| where `local_tests.statistic` is tau.",
    )
    max_rejected_share: NonNegativeNumber | None = Field(
        default=None,
        le=1,
        description="Largest share of the observations that the outlier search may reject.",
    )
    min_redundancy_number: NonNegativeNumber | None = Field(
        default=None, le=1, description="Smallest redundancy number of any image coordinate, arc or tangent."
    )
    min_mean_redundancy_number: NonNegativeNumber | None = Field(
        default=None, le=1, description="Smallest mean of these redundancy numbers."
    )
    min_check_points: int | None = Field(default=None, ge=1, description="Smallest number of check points.")
    check_tests: bool = Field(
        default=False,
        description="Check points and check splines must agree with their predicted precision (all of their tests).",
    )
    max_check_rmse_m: PositiveNumber | None = Field(
        default=None, description="Largest root mean square difference at check points in X, Y or Z, m."
    )
    max_check_rmse_horizontal_m: PositiveNumber | None = Field(
        default=None, description="Largest horizontal RMSE at check points, √(RMSE_X² + RMSE_Y²), m."
    )
    max_check_rmse_vertical_m: PositiveNumber | None = Field(
        default=None, description="Largest vertical RMSE at check points, m."
    )
    max_check_spline_rms_m: PositiveNumber | None = Field(
        default=None, description="Largest root mean square distance across any check spline, m."
    )
    max_position_sigma_m: PositiveNumber | None = Field(
        default=None, description="Largest σ of a coordinate of any perspective centre, m."
    )
    max_angle_sigma_deg: PositiveNumber | None = Field(
        default=None, description="Largest σ of ω, φ or κ of any image, degrees."
    )
    max_point_sigma_m: PositiveNumber | None = Field(
        default=None, description="Largest σ of a coordinate of any tie or check point, m."
    )
    max_sigma_across_m: PositiveNumber | None = Field(
        default=None, description="Largest σ across any spline that is estimated, m."
    )
