"""Foot points on cubic segments: every local minimum of the distance from a ray in space, or in a photo.

All minima of a segment are found (rising_roots.py), so that the nearest of them is nearest for certain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.bernstein import from_powers, value_and_slope
from splinebba_cli.core.curves.foot_polynomials import PhotoStationarity, stationary_in_space
from splinebba_cli.core.curves.rising_roots import Minima
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class SegmentFeet:
    """Local minima of the distance on [0, 1]; sorted by row, nearest first."""

    row: IntArray  # (r,)
    t: FloatArray  # (r,)
    distance: FloatArray  # (r,)
    at_end: BoolArray  # (r,) at 0 or 1, from where the distance rises inwards

    @classmethod
    def sorted(cls, minima: Minima, distance: FloatArray, valid: BoolArray) -> SegmentFeet:
        """The valid ones of minima, in order."""
        order = np.lexsort((distance, minima.column))
        order = order[valid[order]]
        return cls(minima.column[order], minima.t[order], distance[order], minima.end[order] != 0)

    def nearest(self, count: int) -> tuple[FloatArray, FloatArray]:
        """t and distance of the nearest of each of `count` rows; NaN and inf where there is none."""
        t, distance = np.full(count, np.nan), np.full(count, np.inf)
        rows, first = np.unique(self.row, return_index=True)
        t[rows], distance[rows] = self.t[first], self.distance[first]
        return t, distance


def feet_of_rays(polynomials: FloatArray, position: FloatArray, direction: FloatArray) -> SegmentFeet:
    """Foot points of rays X0 + s d, s >= 0, on cubic segments, one segment a ray; the distance in space, metres.

    What lies behind X0 is as far from the ray as from X0 itself.

    Parameters
    ----------
    polynomials : (k, 4, 3) powers of t
    position : (k, 3) perspective centres
    direction : (k, 3) of the rays, of any length: R (x, y, -c)'
    """
    unit = direction / np.linalg.norm(direction, axis=1)[:, None]
    local = polynomials.copy()
    local[:, 0] -= position
    frame = np.concatenate([_across(unit), unit[:, None]], axis=1)
    b = from_powers(np.einsum("kij,knj->nik", frame, local))
    behind = np.flatnonzero((b[:, 2] < 0.0).any(axis=0))
    beside, back = Minima.of(stationary_in_space(b[:, :2])), Minima.of(stationary_in_space(b[:, :, behind]))
    place, _ = value_and_slope(b[:, :, beside.column], beside.t)
    rear, _ = value_and_slope(b[:, :, behind[back.column]], back.t)
    return SegmentFeet.sorted(
        Minima(
            np.concatenate([beside.column, behind[back.column]]),
            np.concatenate([beside.t, back.t]),
            np.concatenate([beside.end, back.end]),
        ),
        np.concatenate([np.linalg.norm(place[:2], axis=0), np.linalg.norm(rear, axis=0)]),
        np.concatenate([place[2] >= 0.0, rear[2] < 0.0]),
    )


def feet_in_photo(seen: FloatArray, xy: FloatArray, whitening: FloatArray | None = None) -> SegmentFeet:
    """Foot points of measured points on cubic segments in the photo, one segment a point.

    Parameters
    ----------
    seen : (k, 4, 3) powers of t of (c u, c v, -w): the segment in the photo frame, u and v times c
    xy : (k, 2) mm, corrected
    whitening : (k, 2, 2), optional
        W: distances are |W (x - xy)|, in sigma instead of millimetres.

    Returns
    -------
    SegmentFeet
        Where the segment is in front of the camera.
    """
    b = from_powers(np.ascontiguousarray(seen.transpose(1, 2, 0)))
    points, depth = b[:, :2], b[:, 2]
    points = points - xy.T * depth[:, None]
    if whitening is not None:
        points = np.einsum("kij,njk->nik", whitening, points)
    every, zero = np.arange(len(xy)), np.zeros((2, len(xy)))
    minima = Minima.of(PhotoStationarity.of(points, depth).at(every, zero))
    n, _ = value_and_slope(points[:, :, minima.column], minima.t)
    d, _ = value_and_slope(depth[:, minima.column], minima.t)
    with np.errstate(all="ignore"):
        return SegmentFeet.sorted(minima, np.hypot(n[0], n[1]) / np.abs(d), d > 0.0)


def _across(unit: FloatArray) -> FloatArray:
    """Two unit vectors across each of some, (k, 2, 3)."""
    least = np.eye(3)[np.argmin(np.abs(unit), axis=1)]
    first = np.cross(unit, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(unit, first)], axis=1)
