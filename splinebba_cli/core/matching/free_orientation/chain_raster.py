"""A raster of a picture whose cells know the nearest point of a chain: where projected samples run along chains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.seen import Seen
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

CELLS = 256  # of the longer side of the picture
ALONGSIDE = 1.5  # gates, from a sample to its point


@dataclass(frozen=True)
class SamplesOnChains:
    """Samples inside of the picture, one row each, and what lies next to them."""

    pose: IntArray  # (k,) ascending
    sample: IntArray  # (k,)
    speed: FloatArray  # (k,) mm per metre of curve
    normal: FloatArray  # (k, 2) across the chain at the nearest point; of no meaning where `hit` is False
    distance: FloatArray  # (k,) across it, sample minus point, mm
    hit: BoolArray  # (k,) runs along a chain


class ChainRaster:
    """Chain points by the cells to which they are nearest."""

    def __init__(self, chains: ImageChains, reach: float, tolerance: float) -> None:
        self._tolerance = np.sin(tolerance)
        self._corner = chains.format_mm[0]
        self._x, self._y = chains.xy.T.copy()
        self._cosine, self._sine = chains.direction.T.copy()
        low, high = chains.format_mm
        self.cell = float((high - low).max()) / CELLS
        shape = np.ceil((high - low) / self.cell).astype(np.int64) + 1
        self._columns = int(shape[1])
        axes = [low[k] + self.cell * (np.arange(shape[k]) + 0.5) for k in range(2)]
        centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=2).reshape(-1, 2)
        usable = np.flatnonzero(np.isfinite(chains.direction).all(axis=1))
        away, near = cKDTree(chains.xy[usable]).query(centres, distance_upper_bound=reach + self.cell)
        self._nearest = np.where(np.isfinite(away), usable[np.minimum(near, len(usable) - 1)], -1)

    def beside(self, seen: Seen, gate: FloatArray) -> SamplesOnChains:
        """Samples before orientations and the chains that they run along.

        Parameters
        ----------
        gate : (s,) mm of every orientation, not wider than the reach
        """
        pose, sample = np.nonzero(seen.inside)
        x, y = seen.x[seen.inside], seen.y[seen.inside]
        along_x, along_y = seen.along_x[seen.inside], seen.along_y[seen.inside]
        speed = np.hypot(along_x, along_y)
        near = self._nearest_point(x, y)
        dx, dy = x - self._x[near], y - self._y[near]
        cosine, sine = self._cosine[near], self._sine[near]
        distance = dx * sine - dy * cosine
        width = gate[pose]
        hit = (near >= 0) & (np.abs(distance) < width)
        hit &= dx * dx + dy * dy < (ALONGSIDE * width) ** 2
        hit &= np.abs(along_x * sine - along_y * cosine) < self._tolerance * speed
        return SamplesOnChains(pose, sample, speed, np.stack([sine, -cosine], axis=1), distance, hit)

    def _nearest_point(self, x: FloatArray, y: FloatArray) -> IntArray:
        left, lower = self._corner
        column, row = ((x - left) / self.cell).astype(np.int64), ((y - lower) / self.cell).astype(np.int64)
        return np.asarray(self._nearest[column * self._columns + row])
