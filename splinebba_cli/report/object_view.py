"""From which side a block is drawn: the plane of the drawing, what everything in it occupies, where it looks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray
from splinebba_cli.report.result_data import ResultData

_CONVERGENT = np.cos(np.radians(20.0))
_DOWN = 0.5  # cosine of the angle to the vertical below which an image looks down


@dataclass(frozen=True)
class ObjectView:
    """A parallel projection along one of the object axes.

    Attributes
    ----------
    data : ResultData
    right, up : number of the object axis that is drawn to the right and upwards
    """

    data: ResultData
    right: int
    up: int

    @property
    def axes(self) -> list[int]:
        """Numbers of the two axes."""
        return [self.right, self.up]

    @property
    def name(self) -> str:
        """``XY``, ``XZ`` or ``YZ``."""
        return f"{'XYZ'[self.right]}{'XYZ'[self.up]}"

    @cached_property
    def stations(self) -> FloatArray:
        """Perspective centres, (m, 2)."""
        return stations(self.data)[:, self.axes]

    @cached_property
    def directions(self) -> FloatArray:
        """Viewing directions in the plane, (m, 2); shorter than 1 as they leave the plane."""
        return viewing_directions(self.data)[:, self.axes]

    def polyline(self, spline: dict[str, Any]) -> FloatArray:
        """Points along a spline, else its knots, (n, 2)."""
        samples = self.data.samples_by_spline.get(spline["id"])
        xyz = coordinates(spline["knots"]) if samples is None else samples.xyz
        line = xyz[:, self.axes]
        if spline["closed"] and len(line) > 2:
            line = np.concatenate([line, line[:1]])
        return line[np.isfinite(line).all(axis=1)]

    def points(self, items: list[dict[str, Any]]) -> FloatArray:
        """Object points, (n, 2)."""
        return coordinates([[item[axis] for axis in "xyz"] for item in items])[:, self.axes]

    def extent(self, more: list[FloatArray]) -> FloatArray:
        """Lower left and upper right corner of everything, (2, 2)."""
        parts = [self.stations, self.points(self.data["points"]), *more]
        parts += [coordinates(spline["knots"])[:, self.axes] for spline in self.data["splines"]]
        every = np.concatenate([part for part in parts if len(part)] or [np.zeros((1, 2))])
        every = every[np.isfinite(every).all(axis=1)]
        if not len(every):
            every = np.zeros((1, 2))
        return np.array([every.min(axis=0), np.maximum(every.max(axis=0), every.min(axis=0) + 1e-6)])


def coordinates(rows: list[Any]) -> FloatArray:
    """Rows of three coordinates, (n, 3)."""
    return np.array(rows, dtype=float).reshape(-1, 3)


def stations(data: ResultData) -> FloatArray:
    """Perspective centres, (m, 3) metres."""
    return coordinates([[image[axis] for axis in "xyz"] for image in data["images"]])


def rotation(image: dict[str, Any]) -> FloatArray:
    """From photo axes to object axes, (3, 3)."""
    angles = np.radians([image[key] for key in ("omega", "phi", "kappa")])
    return rotation_object_from_photo(angles, image["rotation_sequence"])


def viewing_directions(data: ResultData) -> FloatArray:
    """Unit vectors along the camera axes into the scene, (m, 3)."""
    return coordinates([-rotation(image)[:, 2] for image in data["images"]])


def looks_down(data: ResultData) -> bool:
    """Whether most images look down: a plan then shows the block as people know it."""
    directions = viewing_directions(data)
    return not len(directions) or float(np.mean(directions[:, 2] < -_DOWN)) >= 0.5


def needs_side_view(data: ResultData) -> bool:
    """Whether a plan alone hides the block: images look aside, or a quarter of them converge by more than 20°."""
    directions = viewing_directions(data)
    if not looks_down(data) or not len(directions):
        return len(directions) > 0
    mean = directions.mean(axis=0)
    cosine = directions @ (mean / max(float(np.linalg.norm(mean)), 1e-9))
    return float(np.mean(cosine < _CONVERGENT)) >= 0.25


def plan_view(data: ResultData) -> ObjectView:
    """Along the Z axis: X to the right, Y up."""
    return ObjectView(data, 0, 1)


def side_view(data: ResultData) -> ObjectView:
    """The broad side of the block: the longer horizontal axis of the stations to the right, Z up."""
    x, y = np.ptp(stations(data)[:, :2], axis=0)
    return ObjectView(data, 1 if y > x else 0, 2)
