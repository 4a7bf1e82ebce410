"""How well orientations explain the chains of an image by the known curves: cheaply, for many at once.

    F = 2 h / (v + l)

h is the length in the image of projected curves that run along a chain, v that of all projected curves inside the picture,
l that of all chains.  A camera so far away that everything shrinks onto one chain has a small h; one that sees a
single curve of many has a small h against l; one that covers the picture with curves has a large v.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.free_orientation_chains import ImageChains
from splinebba_cli.core.matching.free_orientation_places import CurveSamples
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

CELLS = 256  # of the longer side of the picture
CHUNK = 2000  # orientations that are judged together


@dataclass(frozen=True)
class Seen:
    """Samples before orientations (s, 3, 3), (s, 3); NaN behind the camera."""

    xy: FloatArray  # (s, m, 2) mm
    flow: FloatArray  # (s, m, 2) mm per metre of curve
    inside: BoolArray  # (s, m) in the picture


def see(chains: ImageChains, samples: CurveSamples, rotation: FloatArray, position: FloatArray) -> Seen:
    """Samples of curves as an image sees them under many orientations."""
    c = chains.principal_distance
    p = samples.xyz @ rotation - np.matmul(position[:, None], rotation)
    t = samples.tangent @ rotation
    depth = np.where(p[:, :, 2] < 0.0, -p[:, :, 2], np.nan)
    xy = c * p[:, :, :2] / depth[:, :, None]
    flow = (c * t[:, :, :2] + xy * t[:, :, 2:]) / depth[:, :, None]
    low, high = chains.format_mm
    with np.errstate(invalid="ignore"):
        inside = ((xy >= low) & (xy <= high)).all(axis=2)
    return Seen(xy, flow, inside)


class CoarseScore:
    """F by a raster of the picture whose cells know the nearest point of a chain."""

    def __init__(self, chains: ImageChains, samples: CurveSamples, gate: float, tolerance: float) -> None:
        self.chains, self.samples, self.gate = chains, samples, gate
        self._sine = np.sin(tolerance)
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
        parts = [
            self._score(rotation[k : k + CHUNK], position[k : k + CHUNK])
            for k in range(0, len(rotation), CHUNK)
        ]
        return np.concatenate([np.zeros(0), *parts])

    def _score(self, rotation: FloatArray, position: FloatArray) -> FloatArray:
        seen = see(self.chains, self.samples, rotation, position)
        pose, sample = np.nonzero(seen.inside)
        xy, flow = seen.xy[pose, sample], seen.flow[pose, sample]
        speed = np.linalg.norm(flow, axis=1)
        length = speed * self.samples.length[sample]
        near = self._nearest_point(xy)
        offset, along = xy - self.chains.xy[near], self.chains.direction[near]
        across = np.abs(offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0])
        turned = np.abs(flow[:, 0] * along[:, 1] - flow[:, 1] * along[:, 0])
        hit = (near >= 0) & (across < self.gate) & (np.sum(offset**2, axis=1) < (1.5 * self.gate) ** 2)
        hit &= turned < self._sine * speed
        count = len(rotation)
        explained = np.bincount(pose, length * hit, minlength=count)
        visible = np.bincount(pose, length, minlength=count)
        return np.asarray(2.0 * np.minimum(explained, self._total) / (visible + self._total))

    def _nearest_point(self, xy: FloatArray) -> IntArray:
        cell = ((xy - self.chains.format_mm[0]) / self._cell).astype(np.int64)
        return np.asarray(self._nearest[cell[:, 0] * self._shape[1] + cell[:, 1]])
