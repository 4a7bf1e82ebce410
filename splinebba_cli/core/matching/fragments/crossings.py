"""Where the epipolar lines of the points of one image cross the chains of another.

Planes through both perspective centres are numbered by their angle about the base.  A point lies in one of them, a
step of a chain spans an interval of angles: the crossings are the pairs of a point and an interval that holds it,
found by sorting.  On the step the crossing follows from the plane without approximation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

WIDEST_RAD = 0.5  # steps that span more of the pencil of planes pass by the epipole
BLOCK = 2_000_000  # crossings that are looked at in one go


@dataclass(frozen=True)
class Crossings:
    """Pairs of a point of the reference image and a place on a chain of another image."""

    point: IntArray  # (k,) of the chains
    first: IntArray  # (k,) point of the chains at which the crossed step begins
    fraction: FloatArray  # (k,) of the step, 0 to 1
    depth: FloatArray  # (k,) m/mm along the ray of the point

    @classmethod
    def joined(cls, parts: list[Crossings]) -> Crossings:
        """All crossings of several lists."""
        if not parts:
            whole, real = np.zeros(0, dtype=np.int64), np.zeros(0)
            return cls(whole, whole, real, real)
        return cls(
            np.concatenate([part.point for part in parts]),
            np.concatenate([part.first for part in parts]),
            np.concatenate([part.fraction for part in parts]),
            np.concatenate([part.depth for part in parts]),
        )


def epipolar_crossings(
    views: Views, chains: TracedChains, points: IntArray, segments: IntArray, depths: FloatArray
) -> Crossings:
    """Crossings of points of one image with steps of another.

    Parameters
    ----------
    points : (p,) points of one image
    segments : (s,) first points of steps, all of one other image
    depths : (2,) least and largest depth that is looked at

    Returns
    -------
    Crossings
        In front of both cameras, inside the depths.
    """
    here, there = chains.image[points[0]], chains.image[segments[0]]
    base = views.position[there] - views.position[here]
    if not np.linalg.norm(base) > 0.0:
        return Crossings.joined([])
    axes = _pencil(base, chains.ray[points])
    angle = _plane_angles(axes, chains.ray[points])
    order = np.argsort(angle)
    low, high = _intervals(axes, chains.ray[segments], chains.ray[segments + 1])
    first = np.searchsorted(angle[order], low, side="left")
    count = np.searchsorted(angle[order], high, side="right") - first
    count = np.maximum(count, 0)
    parts = []
    ends = np.cumsum(count)
    for part in np.split(
        np.arange(len(segments)), np.searchsorted(ends, np.arange(BLOCK, int(ends[-1]), BLOCK))
    ):
        total = int(count[part].sum())
        if not total:
            continue
        within = np.arange(total) - np.repeat(np.cumsum(count[part]) - count[part], count[part])
        point = points[order[np.repeat(first[part], count[part]) + within]]
        parts.append(_crossed(views, chains, point, np.repeat(segments[part], count[part]), base, depths))
    return Crossings.joined(parts)


def _pencil(base: FloatArray, rays: FloatArray) -> FloatArray:
    """Two unit vectors across the base, the first towards the rays, (2, 3)."""
    along = base / np.linalg.norm(base)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    mean = unit.mean(axis=0)
    first = mean - along * (along @ mean)
    if np.linalg.norm(first) < 1e-9:
        first = np.linalg.svd(along[None, :])[2][1]
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(along, first)])


def _plane_angles(axes: FloatArray, rays: FloatArray) -> FloatArray:
    return np.asarray(np.arctan2(rays @ axes[1], rays @ axes[0]))


def _intervals(axes: FloatArray, begin: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Angles between which steps lie, (s,) each; empty for steps that pass by the epipole."""
    one, two = _plane_angles(axes, begin), _plane_angles(axes, end)
    wide = np.abs(two - one) > WIDEST_RAD
    low, high = np.minimum(one, two), np.maximum(one, two)
    return np.where(wide, np.inf, low), np.where(wide, -np.inf, high)


def _crossed(
    views: Views,
    chains: TracedChains,
    point: IntArray,
    first: IntArray,
    base: FloatArray,
    depths: FloatArray,
) -> Crossings:
    ray, begin, end = chains.ray[point], chains.ray[first], chains.ray[first + 1]
    plane = np.cross(base, ray)
    one, two = np.sum(plane * begin, axis=1), np.sum(plane * end, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        fraction = np.clip(np.nan_to_num(one / (one - two), nan=0.5), 0.0, 1.0)
        other = begin + fraction[:, None] * (end - begin)
        across = np.cross(ray, other)
        square = np.sum(across**2, axis=1)
        depth = np.sum(np.cross(base[None, :], other) * across, axis=1) / square
        depth_there = np.sum(np.cross(base[None, :], ray) * across, axis=1) / square
    with np.errstate(invalid="ignore"):
        good = np.flatnonzero((depth >= depths[0]) & (depth <= depths[1]) & (depth_there > 0.0))
    return Crossings(point[good], first[good], fraction[good], depth[good])
