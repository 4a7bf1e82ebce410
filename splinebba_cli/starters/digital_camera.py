"""A digital camera of a starter, and its pixels.

column = x / p + width / 2,   row = −y / p + height / 2      (pixel_corner)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import Camera, FloatArray


@dataclass(frozen=True)
class DigitalCamera:
    """Interior orientation as a calibration certificate has it."""

    id: str
    principal_distance_mm: float
    pixel_size_mm: float
    image_size_px: tuple[int, int]  # width, height
    principal_point_offset_mm: tuple[float, float]  # from the image centre, x right, y up
    k1: float
    k2: float

    @property
    def format_mm(self) -> tuple[float, float]:
        """Width and height."""
        width, height = self.image_size_px
        return width * self.pixel_size_mm, height * self.pixel_size_mm

    def planned_format_mm(self, share: float = 0.96) -> tuple[float, float]:
        """Width and height within which points are measured: not at the very border."""
        width, height = self.format_mm
        return share * width, share * height

    def camera(self) -> Camera:
        """The camera of a network; its photo frame begins in the image centre."""
        return Camera(
            id=self.id,
            principal_distance_mm=self.principal_distance_mm,
            principal_point_mm=np.array(self.principal_point_offset_mm),
            radial=np.array([self.k1, self.k2, 0.0]),
            decentring=np.zeros(2),
            affinity=np.zeros(2),
            pixel_size_mm=self.pixel_size_mm,
            format_mm=self.format_mm,
        )

    def pixels(self, photo_xy: FloatArray) -> FloatArray:
        """Columns and rows (n, 2), ``pixel_corner``, of photo coordinates (n, 2) mm."""
        scale = np.array([1.0, -1.0]) / self.pixel_size_mm
        return np.asarray(photo_xy * scale + 0.5 * np.array(self.image_size_px))

    def values(self) -> dict[str, object]:
        """What stands in the texts of a starter."""
        return {
            "camera": self.id,
            "principal_distance_mm": self.principal_distance_mm,
            "pixel_size_mm": self.pixel_size_mm,
            "image_size_px": list(self.image_size_px),
            "principal_point_offset_mm": list(self.principal_point_offset_mm),
            "k1": self.k1,
            "k2": self.k2,
        }
