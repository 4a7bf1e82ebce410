"""Foot points of many measured points at once, on curves of powers: Newton's method in the photo frame.

Along the projected curve p(t), with whitened r(t) = W (p(t) - xy), the squared distance is stationary where
r . r' = 0; Newton's method uses the exact second derivative.  Its error shrinks with its square: a point is left alone
when the error that its last step leaves is below what counts.  (theory, section 3)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.photo_polynomials import (
    CurvePlaces,
    photo_polynomials,
    places_on_segments,
)
from splinebba_cli.core.state import Prepared, State

LARGEST_STEP = 0.125  # of a segment
LEFT_ERROR = 1e-9  # in sigma along the curve, after the last step
MARGIN = 2  # segments on both sides of those where the points of a track are
WHOLE = 12  # segments up to which a curve is taken as a whole
LEAST_ACTIVE = 0.75  # share of the points below which the settled ones are left out


@dataclass(frozen=True)
class SeenSegments:
    """The segments that tracks see, in the frames of their photos."""

    table: FloatArray  # (12, g s), see photo_polynomials
    first: IntArray  # (g,) first segment of every track
    longest: int

    @classmethod
    def of(
        cls, prepared: Prepared, state: State, polynomials: FloatArray, tracks: slice, low: IntArray, high: IntArray
    ) -> SeenSegments:  # fmt: skip
        """Segments low .. high (g,) of tracks, whole curves where these are short, with a margin."""
        curves, image, curve = prepared.curves, prepared.tracks.image[tracks], prepared.tracks.curve[tracks]
        begin, end = curves.segment_start[curve], curves.segment_start[curve + 1]
        short = end - begin <= WHOLE
        first = np.where(short, begin, np.maximum(low - MARGIN, begin))
        last = np.where(short, end - 1, np.minimum(high + MARGIN, end - 1))
        longest = int((last - first).max()) + 1
        segments = np.minimum(first[:, None] + np.arange(longest), end[:, None] - 1)
        table = photo_polynomials(polynomials, prepared.principal_distance, state, image, segments)
        return cls(table, first, longest)

    def columns(self, track: IntArray, segment: IntArray) -> tuple[IntArray, BoolArray]:
        """Columns of the table of points on segments, and whether they are in it."""
        place = segment - self.first[track]
        return track * self.longest + place, (place >= 0) & (place < self.longest)


@dataclass
class Walk:
    """Points under way to their foot points; all arrays (k,)."""

    location: FloatArray
    segment: IntArray
    t: FloatArray
    lost: BoolArray  # out of the table


def foot_points_of_tracks(
    prepared: Prepared, state: State, polynomials: FloatArray, tracks: slice, free: BoolArray, steps: int
) -> tuple[IntArray, FloatArray, BoolArray]:
    """Foot points of the free points of some tracks.

    Parameters
    ----------
    polynomials : (S, 4, 3) of the present segments
    free : (n,) measured points that have a foot point of their own

    Returns
    -------
    points : (k,) the measured points
    location : (k,) not wrapped
    lost : (k,) bool, points that ran out of the segments that their image sees: not finished
    """
    all_tracks, curves = prepared.tracks, prepared.curves
    places = slice(int(all_tracks.starts[tracks.start]), int(all_tracks.starts[tracks.stop]))
    points, track = all_tracks.points[places], all_tracks.of_place[places] - tracks.start
    chosen = free[points]
    if not chosen.all():
        points, track = points[chosen], track[chosen]
    if not len(points):
        return points, np.zeros(0), np.zeros(0, dtype=bool)
    curve = prepared.network.curve_observations.curve[points]
    segment, t = curves.locate(curve, state.location[points])
    low, high = _range_of_tracks(track, segment, curves.segment_start[all_tracks.curve[tracks]])
    seen = SeenSegments.of(prepared, state, polynomials, tracks, low, high)
    walk = Walk(state.location[points], segment, t, np.zeros(len(points), dtype=bool))
    _walk_to_feet(prepared, seen, points, track, curve, walk, steps)
    return points, walk.location, walk.lost


def _range_of_tracks(track: IntArray, segment: IntArray, nowhere: IntArray) -> tuple[IntArray, IntArray]:
    """Lowest and highest segment of the points of every track, points sorted by track, (g,).

    Parameters
    ----------
    nowhere : (g,) the segment of tracks without points
    """
    low, high = nowhere.copy(), nowhere.copy()
    starts = np.flatnonzero(np.append(True, track[1:] != track[:-1]))
    present = track[starts]
    low[present], high[present] = np.minimum.reduceat(segment, starts), np.maximum.reduceat(segment, starts)
    return low, high


def _walk_to_feet(
    prepared: Prepared, seen: SeenSegments, points: IntArray, track: IntArray, curve: IntArray, walk: Walk, steps: int
) -> None:  # fmt: skip
    """Newton's steps of all points, in place."""
    curves, rays = prepared.curves, prepared.rays_by_component
    bounds = prepared.location_bounds
    own = np.arange(len(points))
    rays, low, high = rays[points], bounds[0][points], bounds[1][points]
    for _ in range(steps):
        segment, t = walk.segment[own], walk.t[own]
        column, inside = seen.columns(track[own], segment)
        if not inside.all():
            walk.lost[own[~inside]] = True
            own, rays, low, high = own[inside], rays[inside], low[inside], high[inside]
            segment, t, column = segment[inside], t[inside], column[inside]
        if not len(own):
            return
        step, error = newton_steps(places_on_segments(seen.table, column, t), rays)
        length, location = curves.length[segment], walk.location[own]
        moved = np.minimum(np.maximum(location + step * length, low), high)
        settled = (error < LEFT_ERROR) | (moved == location)
        t += (moved - location) / length
        walk.location[own], walk.t[own] = moved, t
        beyond = np.flatnonzero((t < 0.0) | (t > 1.0))
        if len(beyond):
            out = own[beyond]
            walk.segment[out], walk.t[out] = curves.locate(curve[out], moved[beyond])
        going = ~settled
        if not going.any():
            return
        if np.count_nonzero(going) < LEAST_ACTIVE * len(own):
            own, rays, low, high = own[going], rays[going], low[going], high[going]


def newton_steps(places: CurvePlaces, rays: MeasuredRays) -> tuple[FloatArray, FloatArray]:
    """Safeguarded steps in t, 0 where they are not finite, and the error in sigma that they leave, (k,) each.

    The square of a step of Newton's method, times the speed; a step that is none leaves about its own length.
    """
    with np.errstate(all="ignore"):
        inverse = 1.0 / places.value[2]
        xy = places.value[:2] * inverse
        slope = places.first[:2] - xy * places.first[2]
        slope *= inverse
        bend = places.second[:2] - xy * places.second[2]
        bend -= slope * (2.0 * places.first[2])
        bend *= inverse
        xy -= rays.xy
        r, r1, r2 = rays.whitened(xy), rays.whitened(slope), rays.whitened(bend)
        gradient = r[0] * r1[0] + r[1] * r1[1]
        square = r1[0] * r1[0] + r1[1] * r1[1]
        hessian = square + r[0] * r2[0] + r[1] * r2[1]
        newton = hessian > 0.2 * square
        step = gradient / -np.where(newton, hessian, square)
        step[~np.isfinite(step)] = 0.0
    left = np.sqrt(square) * np.where(newton, step * step, np.abs(step))
    return np.clip(step, -LARGEST_STEP, LARGEST_STEP), left
