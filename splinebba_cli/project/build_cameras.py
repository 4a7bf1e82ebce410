"""Cameras: from the declared frame of measured coordinates to millimetres in the photo.

The inner photo frame of a camera has x right, y up.  Its origin is
- for photo_mm and photo_um: that of the measured coordinates;
- for pixel coordinates: the image centre where image_size_px is given, else the principal point.

    x = px (column + s - column0),   y = -py (row + s - row0)

with s = 0, 1/2, -1/2 for pixel_corner, pixel_centre, pixel_one and (column0, row0) the origin from the outer
corner of the first pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from splinebba_cli.core import network as core
from splinebba_cli.core.network import FloatArray
from splinebba_cli.project import model_camera
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.yaml_source import YamlPath

_SHIFT = {"pixel_corner": 0.0, "pixel_centre": 0.5, "pixel_one": -0.5}
_PRINCIPAL_POINTS = ("principal_point_mm", "principal_point_px", "principal_point_offset_mm")


@dataclass(frozen=True)
class PhotoFrame:
    """How measured coordinates of one camera become photo coordinates."""

    image_coordinates: str
    pixel_size_mm: FloatArray | None  # (2,)
    origin_px: FloatArray | None  # (2,) inner origin, in pixel_corner coordinates
    centred: bool  # whether the inner origin is the image centre
    size_px: tuple[int, int] | None
    principal_distance_mm: float = math.inf
    principal_point_mm: FloatArray = field(default_factory=lambda: np.zeros(2))  # (2,) in the inner frame

    def allows(self, image_coordinates: str) -> bool:
        """Whether coordinates of another frame can be converted."""
        if image_coordinates in _SHIFT:
            return self.origin_px is not None and self.pixel_size_mm is not None
        return self.image_coordinates not in _SHIFT or self.centred

    def photo_xy(self, measured: FloatArray, image_coordinates: str | None = None) -> FloatArray:
        """Photo coordinates, (n, 2) mm, of measured ones in the camera's or another frame."""
        frame = image_coordinates or self.image_coordinates
        if frame == "photo_mm":
            return measured
        if frame == "photo_um":
            return np.asarray(measured * 1e-3)
        assert self.pixel_size_mm is not None
        assert self.origin_px is not None
        scale = self.pixel_size_mm * np.array([1.0, -1.0])
        return np.asarray((measured + (_SHIFT[frame] - self.origin_px)) * scale)


def build_cameras(building: Building) -> tuple[list[core.Camera], list[PhotoFrame]]:
    """Core cameras and their frames, in the order of the project."""
    cameras, frames = [], []
    seen: dict[str, int] = {}
    for number, camera in enumerate(building.model.cameras):
        path: YamlPath = ("cameras", number)
        if camera.id in seen:
            building.duplicate("camera", camera.id, building.source.place((*path, "id")), seen[camera.id])
        seen.setdefault(camera.id, building.source.place((*path, "id")).line or 0)
        built = _build(camera, path, building)
        cameras.append(built[0])
        frames.append(built[1])
    return cameras, frames


def _build(camera: model_camera.Camera, path: YamlPath, building: Building) -> tuple[core.Camera, PhotoFrame]:
    error, place = building.collector.error, building.source.place
    if camera.interior == "free":
        help = "write `interior: fixed`, or leave it out"
        error("SBB208", "a free interior orientation is not available yet", place((*path, "interior")), help)
    given = [name for name in _PRINCIPAL_POINTS if getattr(camera, name) is not None]
    if len(given) > 1:
        error(
            "SBB209",
            f"`{given[0]}` and `{given[1]}` both given",
            place((*path, given[1]), key=True),
            "give one",
        )
    pixels = camera.image_coordinates in _SHIFT
    if pixels and camera.pixel_size_mm is None:
        message = f"camera `{camera.id}` measures in pixels but has no `pixel_size_mm`"
        error(
            "SBB202",
            message,
            place((*path, "image_coordinates")),
            "pixel_size_mm: one number, or [x, y], in mm",
        )
    if pixels and not given:
        message = f"camera `{camera.id}` measures in pixels but has no principal point"
        help = (
            "give principal_point_px, principal_point_mm, or principal_point_offset_mm ([0, 0]: the centre)"
        )
        error("SBB202", message, place(path), help)
    if camera.image_size_px is not None and min(camera.image_size_px) < 1:
        error("SBB205", "`image_size_px` must be at least 1", place((*path, "image_size_px")))
    frame, principal_point = _frame(camera, pixels, path, building)
    built = core.Camera(
        id=camera.id,
        principal_distance_mm=camera.principal_distance_mm,
        principal_point_mm=principal_point,
        radial=np.array([camera.distortion.k1, camera.distortion.k2, camera.distortion.k3]),
        decentring=np.array([camera.distortion.p1, camera.distortion.p2]),
        affinity=np.array([camera.affinity.b1, camera.affinity.b2]),
        pixel_size_mm=None if camera.pixel_size_mm is None else float(np.sqrt(np.prod(camera.pixel_size_mm))),
        format_mm=_format(camera),
    )
    return built, replace(
        frame, principal_distance_mm=camera.principal_distance_mm, principal_point_mm=principal_point
    )


def _format(camera: model_camera.Camera) -> tuple[float, float] | None:
    if camera.format_mm is not None:
        return camera.format_mm
    if camera.image_size_px is None or camera.pixel_size_mm is None:
        return None
    width, height = np.array(camera.image_size_px) * np.array(camera.pixel_size_mm)
    return float(width), float(height)


def _frame(
    camera: model_camera.Camera, pixels: bool, path: YamlPath, building: Building
) -> tuple[PhotoFrame, FloatArray]:
    """The frame of measured coordinates, and the principal point in the inner frame, (2,) mm."""
    size = camera.image_size_px
    pixel = None if camera.pixel_size_mm is None else np.array(camera.pixel_size_mm)
    if not pixels:
        wrong = next((n for n in _PRINCIPAL_POINTS[1:] if getattr(camera, n) is not None), None)
        if wrong is not None:
            message = f"`{wrong}` with `image_coordinates: {camera.image_coordinates}`"
            help = "give principal_point_mm in the photo frame"
            building.collector.error("SBB209", message, building.source.place((*path, wrong), key=True), help)
        frame = PhotoFrame(camera.image_coordinates, pixel, None, False, size)
        return frame, np.array(camera.principal_point_mm or (0.0, 0.0))
    scale = pixel if pixel is not None else np.ones(2)
    shift = _SHIFT[camera.image_coordinates]
    centre = None if size is None else np.array(size) / 2.0
    if camera.principal_point_px is not None:
        corner = np.array(camera.principal_point_px) + shift
    elif camera.principal_point_mm is not None:
        corner = np.array(camera.principal_point_mm) / scale + shift
    elif camera.principal_point_offset_mm is not None:
        if centre is None:
            where = building.source.place((*path, "principal_point_offset_mm"), key=True)
            building.collector.error("SBB202", "`principal_point_offset_mm` needs `image_size_px`", where)
            centre = np.zeros(2)
        frame = PhotoFrame(camera.image_coordinates, pixel, centre, True, size)
        return frame, np.array(camera.principal_point_offset_mm)
    else:
        corner = np.zeros(2)
    origin = corner if centre is None else centre
    frame = PhotoFrame(camera.image_coordinates, pixel, origin, centre is not None, size)
    return frame, np.asarray((corner - origin) * scale * np.array([1.0, -1.0]))
