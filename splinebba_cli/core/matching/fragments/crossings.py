"""Where the epipolar lines of the points of one image cross the chains of another.

Planes through both perspective centres are numbered by their angle about the base.  A point lies in one of them, a
step of a chain spans an interval of angles: the crossings are the pairs of a point and an interval that holds it,
found by sorting.  In its plane a ray is numbered by its angle from the base: the depths that are looked at span an
interval of these angles, divided into belts, so that steps far along the epipolar line are not even touched.  On the
step the crossing follows from the plane without approximation.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

WIDEST_RAD = 0.5  # steps that span more of the pencil of planes pass by the epipole
BLOCK = 2_000_000  # crossings that are looked at in one go
MOST_BELTS = 2000  # over half a turn
LAST = 1.0 - 1e-9  # of a step: its end is a place of this step, not of the next piece
ROUNDING = 1e-9  # rad, of angles from the base


@dataclass(frozen=True)
class Crossings:
    """Pairs of a point of the reference image and a place on a chain of another image."""

    point: IntArray  # (k,) of the chains
    first: IntArray  # (k,) point of the chains at which the crossed step begins
    fraction: FloatArray  # (k,) of the step, 0 up to but not 1
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
    points : (p,) points of one image, ascending
    segments : (s,) first points of steps, all of one other image, ascending
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
    belts = _belts(chains, points, segments, base, depths)
    parts = []
    for point, first in _in_common_planes(axes, chains, belts):
        parts.append(_crossed(chains, point, first, base, depths))
    return Crossings.joined(parts)


@dataclass(frozen=True)
class _Belts:
    """Points and steps by belts of the angle from the base; each stands in every belt that it touches."""

    point: IntArray
    point_belt: IntArray
    segment: IntArray
    segment_belt: IntArray
    first_of_point: IntArray  # by number of the point less the least
    first_of_segment: IntArray  # likewise


def _belts(
    chains: TracedChains,
    points: IntArray,
    segments: IntArray,
    base: FloatArray,
    depths: FloatArray,
) -> _Belts:
    length = np.linalg.norm(base)
    along = base / length
    ray = chains.ray[points]
    near = _angle_from(along, depths[0] * ray - base)
    far = _angle_from(along, depths[1] * ray - base)
    one, two = _angle_from(along, chains.ray[segments]), _angle_from(along, chains.ray[segments + 1])
    low, high = np.minimum(near, far), np.maximum(near, far)
    width = max(float(np.median(high - low)), float(np.median(np.abs(two - one))), np.pi / MOST_BELTS)
    point, point_belt, first_of_point = _spread(points, low, high, width)
    segment, segment_belt, first_of_segment = _spread(
        segments, np.minimum(one, two), np.maximum(one, two), width
    )
    return _Belts(point, point_belt, segment, segment_belt, first_of_point, first_of_segment)


def _angle_from(along: FloatArray, ray: FloatArray) -> FloatArray:
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(ray, along), axis=1), ray @ along))


def _spread(
    things: IntArray, low: FloatArray, high: FloatArray, width: float
) -> tuple[IntArray, IntArray, IntArray]:
    """Things in every belt that their interval touches, the belts, and the first belt of each."""
    first = np.floor((low - ROUNDING) / width).astype(np.int64)
    count = np.floor((high + ROUNDING) / width).astype(np.int64) - first + 1
    within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    of_all = np.zeros(int(things[-1] - things[0]) + 1, dtype=np.int64)
    of_all[things - things[0]] = first
    return np.repeat(things, count), np.repeat(first, count) + within, of_all


def _in_common_planes(
    axes: FloatArray, chains: TracedChains, belts: _Belts
) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs of a point and a step of the same belt that have an epipolar plane in common, in blocks."""
    turn = 4.0 * np.pi
    angle = _plane_angles(axes, chains.ray[belts.point]) + turn * belts.point_belt
    order = np.argsort(angle)
    low, high = _intervals(axes, chains.ray[belts.segment], chains.ray[belts.segment + 1])
    angle, offset = angle[order], turn * belts.segment_belt
    start = np.searchsorted(angle, low + offset, side="left")
    count = np.maximum(np.searchsorted(angle, high + offset, side="right") - start, 0)
    ends = np.cumsum(count)
    total = int(ends[-1]) if len(ends) else 0
    for part in np.split(np.arange(len(count)), np.searchsorted(ends, np.arange(BLOCK, total, BLOCK))):
        size = count[part]
        within = np.arange(int(size.sum())) - np.repeat(np.cumsum(size) - size, size)
        chosen = order[np.repeat(start[part], size) + within]
        point, segment = belts.point[chosen], np.repeat(belts.segment[part], size)
        belt = np.maximum(
            belts.first_of_point[point - belts.point[0]], belts.first_of_segment[segment - belts.segment[0]]
        )
        once = belt == np.repeat(belts.segment_belt[part], size)
        yield point[once], segment[once]


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
        fraction = np.clip(np.nan_to_num(one / (one - two), nan=0.5), 0.0, LAST)
        other = begin + fraction[:, None] * (end - begin)
        across = np.cross(ray, other)
        square = np.sum(across**2, axis=1)
        depth = np.sum(np.cross(base[None, :], other) * across, axis=1) / square
        depth_there = np.sum(np.cross(base[None, :], ray) * across, axis=1) / square
    with np.errstate(invalid="ignore"):
        good = np.flatnonzero((depth >= depths[0]) & (depth <= depths[1]) & (depth_there > 0.0))
    return Crossings(point[good], first[good], fraction[good], depth[good])
