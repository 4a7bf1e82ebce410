"""The project file, version 1: its sections, with units."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from splinebba_cli.project.model_acceptance import Acceptance
from splinebba_cli.project.model_adjustment import Adjustment, Knots
from splinebba_cli.project.model_camera import Camera
from splinebba_cli.project.model_features import PointEntry, SplineEntry
from splinebba_cli.project.model_images import ImageEntry
from splinebba_cli.project.model_matching import Matching
from splinebba_cli.project.model_observations import Observations
from splinebba_cli.project.model_simulation import Simulation
from splinebba_cli.project.scalars import (
    AngleUnit,
    FileName,
    Model,
    Name,
    Note,
    OrItsTable,
    RotationSequence,
    TriplePosition,
)

FORMAT_VERSION = 1


class ProjectInfo(Model):
    """What the project is, and its units."""

    name: Name = Field(description="Name of the project.")
    description: Note | None = Field(default=None, description="What it is, for readers.")
    crs: Note | None = Field(
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
    table_folders: list[FileName] = Field(
        default_factory=list,
        description="Further folders, relative to the project file, in which side tables may lie; default: none, all "
        "tables lie in the folder of the project file or below it.",
    )
    local_origin: TriplePosition | None = Field(
        default=None,
        description="Origin of the inner frame, m; default: a rounded one near the control.",
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
    matching: Matching = Field(default_factory=Matching, description="How `match` labels chains.")
    acceptance: Acceptance = Field(default_factory=Acceptance, description="What a result must satisfy.")
    simulation: Simulation | None = Field(
        default=None, description="How `simulate` measures the project anew."
    )


__all__ = ["FORMAT_VERSION", "Acceptance", "Adjustment", "Knots", "Project", "ProjectInfo", "Simulation"]
