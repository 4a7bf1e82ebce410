"""Measured image coordinates."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from splinebba_cli.project.model_tables import TableOrRows
from splinebba_cli.project.scalars import AngleUnit, ImageCoordinates, Model, Name, PositiveNumber, ScalePair


class ObservationGroup(TableOrRows):
    """Image points of one kind and precision."""

    name: Name | None = Field(default=None, description="Name of the group, for residual statistics.")
    image_coordinates: ImageCoordinates | None = Field(
        default=None, description="Frame and unit of x and y; default: as the camera says."
    )
    sigma_px: ScalePair | None = Field(
        default=None, description="σ of x and y, pixels: one number or [x, y]."
    )
    sigma_um: ScalePair | None = Field(default=None, description="σ of x and y, µm: one number or [x, y].")
    sigma_mm: ScalePair | None = Field(default=None, description="σ of x and y, mm: one number or [x, y].")


class PointGroup(ObservationGroup):
    """Image points of object points: columns image, point, x, y [, σ] [, use].

    `use` (yes, no; in every table of observations): `no` takes a row out of the adjustment; it stays in the tables and
    the report, with its residual against the adjusted values.
    """


class SplineGroup(ObservationGroup):
    """Image points anywhere on splines: columns image, spline, x, y [, σ] [, location] [, segment] [, mark]
    [, use].

    A mark names a measured point for arc lengths and tangents, once an image and spline; without the column the points
    of an image and spline are 1, 2, 3 … in their order.
    """


class ChainGroup(ObservationGroup):
    """Image points on edges that nobody has assigned to a spline, single or as chains of a tracing tool: columns image,
    x, y [, chain] [, direction or normal_x, normal_y] [, σ] [, use].

    The rows of a chain stand together, in the order of tracing; a chain belongs to one image, and the same name in
    another image is another chain.  Without the column `chain`, or where it is empty, points are single.  `direction`
    is that of the edge, up to half a turn, counted as that of a tangent; `normal_x`, `normal_y` are a vector across the
    edge of any length.  `adjust` passes over these points; `match` finds the splines to which they belong.
    """

    angle_unit: AngleUnit | None = Field(
        default=None, description="Unit of the directions; default: that of the project."
    )


class ArcLengthGroup(TableOrRows):
    """Lengths of projected splines between two measured points of one image: columns image, spline, from, to, length
    [, σ] [, use].

    `from` and `to` are marks of measured points.  A point may end one arc and begin another.  Arc lengths come from
    the same edge pixels as the points and are correlated with them, which the adjustment does not know: give them a
    larger σ.
    """

    name: Name | None = Field(default=None, description="Name of the group, for residual statistics.")
    method: Literal["gauss-legendre", "simpson"] = Field(
        default="gauss-legendre",
        description=(
            "Integration: gauss-legendre, ten nodes a piece, split at knots; simpson: one step (Lee 2008, eq. "
            "3.38), biased where points are further apart than a third of a segment."
        ),
    )
    image_coordinates: ImageCoordinates | None = Field(
        default=None, description="Unit of the lengths is that of this frame; default: as the camera says."
    )
    sigma_px: PositiveNumber | None = Field(default=None, description="σ of the lengths, pixels.")
    sigma_um: PositiveNumber | None = Field(default=None, description="σ of the lengths, µm.")
    sigma_mm: PositiveNumber | None = Field(default=None, description="σ of the lengths, mm.")


class TangentGroup(TableOrRows):
    """Directions of projected splines in an image at measured points: columns image, spline, at, direction [, sigma]
    [, use].

    `at` is the mark of a measured point; the angle counts from the x axis towards the y axis of the image coordinates
    (clockwise on the screen where y points down).  Like arc lengths, directions are correlated with the points.
    """

    name: Name | None = Field(default=None, description="Name of the group, for residual statistics.")
    image_coordinates: ImageCoordinates | None = Field(
        default=None, description="Frame in which the angles count; default: as the camera says."
    )
    angle_unit: AngleUnit | None = Field(
        default=None, description="Unit of the directions and their σ; default: that of the project."
    )
    directed: bool = Field(
        default=False,
        description=(
            "true: the direction has the sense of the spline, from its first to its last knot; false: known up to "
            "half a turn."
        ),
    )
    sigma: PositiveNumber | None = Field(
        default=None, description="σ of the directions, in their unit; or a column `sigma`."
    )


class DistanceGroup(TableOrRows):
    """Lengths in the object: scale bars between points, or bases between images: columns from, to, length [, sigma_m]
    [, use].

    They fix the scale of a network that has no control.
    """

    name: Name | None = Field(default=None, description="Name of the group, for residual statistics.")
    between: Literal["points", "images"] = Field(
        default="points",
        description="points: `from` and `to` are points of the project; images: perspective centres of images.",
    )
    sigma_m: PositiveNumber | None = Field(
        default=None, description="σ of the lengths, m; or a column `sigma_m`."
    )


class Observations(Model):
    """All measurements."""

    spline_points: list[SplineGroup] = Field(
        default_factory=list,
        description="Points measured on splines; each has its own unknown location on the curve.",
    )
    points: list[PointGroup] = Field(default_factory=list, description="Image points of object points.")
    chains: list[ChainGroup] = Field(
        default_factory=list,
        description="Points on edges without the name of a spline, single or in chains; `match` labels them.",
    )
    arc_lengths: list[ArcLengthGroup] = Field(
        default_factory=list, description="Lengths of projected splines between measured points."
    )
    tangents: list[TangentGroup] = Field(
        default_factory=list, description="Directions of projected splines at measured points."
    )
    distances: list[DistanceGroup] = Field(
        default_factory=list, description="Lengths between points or between perspective centres, m."
    )
