"""Cameras: interior orientation and the frame of the measured coordinates."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from splinebba_cli.project.scalars import (
    Id,
    ImageCoordinates,
    Model,
    Number,
    Pair,
    PositiveNumber,
    ScalePair,
)


class Distortion(Model):
    """Brown's distortion, as a correction of measured coordinates: corrected = measured + Brown(measured).

    With (x, y) from the principal point in mm, x right, y up, and r² = x² + y²:
    dx = x (k1 r² + k2 r⁴ + k3 r⁶) + p1 (r² + 2x²) + 2 p2 x y.
    """

    k1: Number = Field(default=0.0, description="Radial distortion K1, mm⁻².")
    k2: Number = Field(default=0.0, description="Radial distortion K2, mm⁻⁴.")
    k3: Number = Field(default=0.0, description="Radial distortion K3, mm⁻⁶.")
    p1: Number = Field(default=0.0, description="Decentring distortion P1, mm⁻¹.")
    p2: Number = Field(default=0.0, description="Decentring distortion P2, mm⁻¹.")


class Affinity(Model):
    """Affinity: dx = b1 x + b2 y, added to the distortion."""

    b1: Number = Field(default=0.0, description="Scale of x, without unit.")
    b2: Number = Field(default=0.0, description="Shear, without unit.")


class Camera(Model):
    """A camera; one for all images that share its interior orientation."""

    id: Id = Field(description="Id, always a text.")
    principal_distance_mm: PositiveNumber = Field(description="Principal distance c, mm (> 0).")
    image_coordinates: ImageCoordinates = Field(
        description=(
            "Frame and unit of measured image coordinates. photo_mm, photo_um: x right, y up. pixel_corner: "
            "column right, row down, (0, 0) the outer corner of the first pixel; pixel_centre: (0, 0) the "
            "centre of the first pixel; pixel_one: (1, 1) the centre of the first pixel."
        )
    )
    pixel_size_mm: ScalePair | None = Field(
        default=None, description="Pixel size, mm: one number or [width, height]."
    )
    image_size_px: tuple[int, int] | None = Field(
        default=None, description="Image size, pixels: [width, height]."
    )
    format_mm: tuple[PositiveNumber, PositiveNumber] | None = Field(
        default=None,
        description="Image format, mm: [width, height]; for images in pixels it follows from their size.",
    )
    principal_point_mm: Pair | None = Field(
        default=None,
        description=(
            "Principal point, mm. photo_*: in the photo frame, x right, y up (default [0, 0]). pixel_*: in "
            "the frame of the pixels times the pixel size, x right, y down, from the pixel (0, 0)."
        ),
    )
    principal_point_px: Pair | None = Field(
        default=None,
        description="Principal point, pixels, in the frame of the measured pixel coordinates: [column, row].",
    )
    principal_point_offset_mm: Pair | None = Field(
        default=None,
        description="Principal point from the image centre, mm, x right, y up; needs image_size_px.",
    )
    distortion: Distortion = Field(
        default_factory=Distortion, description="Lens distortion (backward Brown model)."
    )
    affinity: Affinity = Field(default_factory=Affinity, description="Affinity of the image coordinates.")
    interior: Literal["fixed", "free"] = Field(default="fixed", description="Interior orientation: fixed.")
