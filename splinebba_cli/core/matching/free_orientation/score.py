"""How well orientations explain the chains of an image by the known curves: cheaply, for many at once.

    F = 2 h / (v + l)

h is the length in the image of projected curves that run along a chain, v that of all projected curves inside the
picture, l that of all chains.  A camera so far away that everything shrinks onto one chain has a small h; one that sees
a single curve of many has a small h against l; one that covers the picture with curves has a large v.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.places import CurveSamples
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

CELLS = 256  # of the longer side of the picture
TOGETHER = 15_000  # samples that are judged together: arrays that stay in the cache


@dataclass(frozen=True)
class Seen:
    """Samples before orientations (s, 3, 3), (s, 3), component by component; NaN behind the camera."""

    x: FloatArray  # (s, m) mm
    y: FloatArray
    along_x: FloatArray  # (s, m) mm per metre of curve
    along_y: FloatArray
    inside: BoolArray  # (s, m) in the picture

    def one(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Places and directions (k, 2) of some samples before the first orientation."""
        xy = np.column_stack([self.x[0, rows], self.y[0, rows]])
        return xy, np.column_stack([self.along_x[0, rows], self.along_y[0, rows]])


def see(chains: ImageChains, samples: CurveSamples, rotation: FloatArray, position: FloatArray) -> Seen:
    """Samples of curves as an image sees them under many orientations."""
    c = chains.principal_distance
    u, v, w = (
        rotation[:, :, k] @ samples.xyz.T - _dot(rotation[:, :, k], position)[:, None] for k in range(3)
    )
    du, dv, dw = (rotation[:, :, k] @ samples.tangent.T for k in range(3))
    factor = np.where(w < 0.0, -1.0 / np.where(w < 0.0, w, -1.0), np.nan)
    x, y = c * u * factor, c * v * factor
    (left, lower), (right, upper) = chains.format_mm
    with np.errstate(invalid="ignore"):
        inside = (x >= left) & (x <= right) & (y >= lower) & (y <= upper)
    return Seen(x, y, (c * du + x * dw) * factor, (c * dv + y * dw) * factor, inside)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


class CoarseScore:
    """F by a raster of the picture whose cells know the nearest point of a chain."""

    def __init__(self, chains: ImageChains, samples: CurveSamples, gate: float, tolerance: float) -> None:
        self.chains, self.samples, self.gate = chains, samples, gate
        self._tolerance = np.sin(tolerance)
        self._x, self._y = chains.xy.T.copy()
        self._cosine, self._sine = chains.direction.T.copy()
        low, high = chains.format_mm
        self._cell = float((high - low).max()) / CELLS
        self._shape = np.ceil((high - low) / self._cell).astype(np.int64) + 1
        axes = [low[k] + self._cell * (np.arange(self._shape[k]) + 0.5) for k in range(2)]
        centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=2).reshape(-1, 2)
        usable = np.flatnonzero(np.isfinite(chains.direction).all(axis=1))
        reach = gate + self._cell
        away, near = cKDTree(chains.xy[usable]).query(centres, distance_upper_bound=reach)
        self._nearest = np.where(np.isfinite(away), usable[np.minimum(near, len(usable) - 1)], -1)
        self._total = float(chains.length.sum())

    def __call__(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        """F of orientations (s, 3, 3), (s, 3): (s,)."""
        step = max(TOGETHER // max(len(self.samples.length), 1), 1)
        parts = [
            self._score(rotation[k : k + step], position[k : k + step]) for k in range(0, len(rotation), step)
        ]
        return np.concatenate([np.zeros(0), *parts])

    def _score(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        seen = see(self.chains, self.samples, rotation, position)
        pose, sample = np.nonzero(seen.inside)
        x, y = seen.x[seen.inside], seen.y[seen.inside]
        along_x, along_y = seen.along_x[seen.inside], seen.along_y[seen.inside]
        speed = np.hypot(along_x, along_y)
        length = speed * self.samples.length[sample]
        near = self._nearest_point(x, y)
        dx, dy = x - self._x[near], y - self._y[near]
        cosine, sine = self._cosine[near], self._sine[near]
        hit = (near >= 0) & (np.abs(dx * sine - dy * cosine) < self.gate)
        hit &= dx * dx + dy * dy < (1.5 * self.gate) ** 2
        hit &= np.abs(along_x * sine - along_y * cosine) < self._tolerance * speed
        count = len(rotation)
        explained = np.bincount(pose, length * hit, minlength=count)
        visible = np.bincount(pose, length, minlength=count)
        return np.asarray(2.0 * np.minimum(explained, self._total) / (visible + self._total))

    def _nearest_point(self, x: FloatArray, y: FloatArray) -> IntArray:
        left, lower = self.chains.format_mm[0]
        column, row = ((x - left) / self._cell).astype(np.int64), ((y - lower) / self._cell).astype(np.int64)
        return np.asarray(self._nearest[column * self._shape[1] + row])
