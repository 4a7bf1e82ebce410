"""The project file, version 1: its sections, with units."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from splinebba_cli.project.model_camera import Camera
from splinebba_cli.project.model_features import PointEntry, SplineEntry
from splinebba_cli.project.model_images import ImageEntry
from splinebba_cli.project.model_observations import Observations
from splinebba_cli.project.model_simulation import Simulation
from splinebba_cli.project.scalars import (
    AngleUnit,
    Model,
    OrItsTable,
    PositiveNumber,
    RotationSequence,
    Text,
    TriplePosition,
)

FORMAT_VERSION = 1


class ProjectInfo(Model):
    """What the project is, and its units."""

    name: Text = Field(description="Name of the project.", min_length=1)
    description: Text | None = Field(default=None, description="What it is, for readers.")
    crs: Text | None = Field(
        default=None, description="Note on the coordinate reference system; must be Cartesian."
    )
    object_unit: Literal["m"] = Field(default="m", description="Unit of object coordinates: metres.")
    angle_unit: AngleUnit | None = Field(
        default=None,
        description="Unit of angles and their σ: deg (360), gon (400) or rad. Needed where there are any.",
    )
    rotation_sequence: RotationSequence | None = Field(
        default=None,
        description=(
            "omega-phi-kappa: R = Rx(ω) Ry(φ) Rz(κ); phi-omega-kappa: R = Ry(φ) Rx(ω) Rz(κ); R turns "
            "photo axes into object axes. Needed where there are angles."
        ),
    )
    local_origin: TriplePosition | None = Field(
        default=None,
        description="Origin of the inner frame, m; default: a rounded one near the control.",
    )


class Knots(Model):
    """What the program may do with the knots of tie splines."""

    spacing_m: PositiveNumber | None = Field(
        default=None, description="Space knots to about this distance, m; default: keep."
    )
    insert: bool = Field(
        default=False, description="Insert knots where residuals along a curve are systematic."
    )
    drop: bool = Field(default=False, description="Drop knots that no measurement supports.")


class Adjustment(Model):
    """Settings of the adjustment."""

    datum: Literal["control", "minimal"] = Field(
        default="control", description="control: by control and priors; minimal: seven minimal constraints."
    )
    max_iterations: int = Field(default=50, ge=1, le=10_000, description="Largest number of iterations.")
    alpha: PositiveNumber = Field(default=0.05, lt=1, description="Level of significance of the tests.")
    sigma0_prior: PositiveNumber = Field(
        default=1.0, description="A-priori standard deviation of unit weight."
    )
    gauge_sigma_m: PositiveNumber | None = Field(
        default=None,
        description=(
            "σ of the gauge conditions along curves, m; default: a tenth of the mean knot distance for natural and "
            "cardinal splines and lines, a thousandth of it (conics, Fourier: of the radius) for other families."
        ),
    )
    gauge_conditions: Literal["needed", "all"] = Field(
        default="needed",
        description="needed: conditions are dropped where the measurements determine the place along the curve; "
        "all: every condition stays (knots that the program spaces itself always keep theirs).",
    )
    scale_dispersion: bool = Field(
        default=True, description="Whether standard deviations are multiplied by σ̂₀."
    )
    staged: bool = Field(
        default=True, description="Orientation from points first, then curves, then all together."
    )
    knots: Knots = Field(default_factory=Knots, description="Policy for the knots of tie splines.")


class Acceptance(Model):
    """What a result must satisfy; a violation ends `adjust` with exit code 1, the results are written."""

    global_test: bool = Field(
        default=False, description="The χ² test of the variance of unit weight must pass."
    )
    max_sigma0: PositiveNumber | None = Field(
        default=None, description="Largest σ̂₀ (in units of sigma0_prior's unit weight)."
    )
    max_check_rmse_m: PositiveNumber | None = Field(
        default=None, description="Largest root mean square difference at check points in X, Y or Z, m."
    )
    max_check_spline_rms_m: PositiveNumber | None = Field(
        default=None, description="Largest root mean square distance across any check spline, m."
    )
    max_position_sigma_m: PositiveNumber | None = Field(
        default=None, description="Largest σ of a coordinate of any perspective centre, m."
    )


def _as_list(value: Any) -> Any:
    """One table may stand where a list of entries may."""
    return [value] if isinstance(value, dict) else value


class Project(Model):
    """A project of splinebba: cameras, images, splines, points, observations, and how to adjust them."""

    version: Annotated[int, Field(ge=FORMAT_VERSION, le=FORMAT_VERSION)] = Field(
        description="Version of this format: 1."
    )
    project: ProjectInfo = Field(description="Name and units.")
    cameras: list[Camera] = Field(description="Cameras.", min_length=1)
    images: Annotated[list[ImageEntry], Field(min_length=1), BeforeValidator(_as_list), OrItsTable()] = Field(
        description="Images: a table, or a list of images and tables."
    )
    splines: Annotated[list[SplineEntry], BeforeValidator(_as_list), OrItsTable()] = Field(
        default_factory=list, description="Splines and other linear features."
    )
    points: Annotated[list[PointEntry], BeforeValidator(_as_list), OrItsTable()] = Field(
        default_factory=list, description="Points of the object."
    )
    observations: Observations = Field(
        default_factory=Observations, description="Measured image coordinates."
    )
    adjustment: Adjustment = Field(default_factory=Adjustment, description="How to adjust.")
    acceptance: Acceptance = Field(default_factory=Acceptance, description="What a result must satisfy.")
    simulation: Simulation | None = Field(
        default=None, description="How `simulate` measures the project anew."
    )


__all__ = ["FORMAT_VERSION", "Acceptance", "Adjustment", "Knots", "Project", "ProjectInfo", "Simulation"]
