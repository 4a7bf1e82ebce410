"""Measured image coordinates."""

from __future__ import annotations

from pydantic import Field

from splinebba_cli.project.model_tables import TableOrRows
from splinebba_cli.project.scalars import ImageCoordinates, Model, ScalePair, Text


class ObservationGroup(TableOrRows):
    """Image points of one kind and precision."""

    name: Text | None = Field(default=None, description="Name of the group, for residual statistics.")
    image_coordinates: ImageCoordinates | None = Field(
        default=None, description="Frame and unit of x and y; default: as the camera says."
    )
    sigma_px: ScalePair | None = Field(
        default=None, description="σ of x and y, pixels: one number or [x, y]."
    )
    sigma_um: ScalePair | None = Field(default=None, description="σ of x and y, µm: one number or [x, y].")
    sigma_mm: ScalePair | None = Field(default=None, description="σ of x and y, mm: one number or [x, y].")


class PointGroup(ObservationGroup):
    """Image points of object points: columns image, point, x, y [, σ]."""


class SplineGroup(ObservationGroup):
    """Image points anywhere on splines: columns image, spline, x, y [, σ] [, location] [, segment]."""


class Observations(Model):
    """All measurements."""

    spline_points: list[SplineGroup] = Field(
        default_factory=list,
        description="Points measured on splines; each has its own unknown location on the curve.",
    )
    points: list[PointGroup] = Field(default_factory=list, description="Image points of object points.")
