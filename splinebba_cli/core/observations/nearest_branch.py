"""Which foot points are certainly the nearest places of their curves, so that no search is needed.

A measured point at distance d from its foot point: a nearer place would lie in the circle of radius d.

- Another segment is outside of it where its hull (the circle around its projected Bezier points) is.
- On a segment with |p'| >= m along its chord and |p''| <= M, and on the one that continues it smoothly, the squared
  distance is convex wherever d' M < m^2, d' the distance of the places concerned; the part of such a nearly straight
  curve that begins and ends in the circle stays within 5 d.

So d < m^2 / (10 M), with a factor of 2 for safety, is enough: for a whole curve that is smooth and nowhere turns more
than 60 degrees from its chord, or for the segment of the foot point and its neighbours.  The rest is searched, and
everything is where error ellipses are no circles: distances in the photo then do not tell what is nearest in sigma.
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
from splinebba_cli.core.threads import in_threads

WHOLE = 16  # segments of a curve up to which this is asked
REACH = 20.0
ROUND = 1.1  # ratio of the axes of error ellipses up to which these are circles
FORWARD = 0.5  # cosine of the largest angle of a whole curve against its chord
STRAIGHT = 0.866  # cosine of the largest angle against the chord, and between chords of neighbours
SMOOTH = 1e-6  # 1 - cosine of the angle at a joint
EVEN_DEPTH = 1.05  # ratio of the largest to the smallest depth along a segment
FOOT = 1e-3  # of sigma along the curve: nearer to a foot point than that
BEYOND = 0.02  # of a segment, how far behind its ends a foot point may be


def surely_nearest(prepared: Prepared, state: State) -> BoolArray:
    """Whether each foot point (n,) is certainly nearest; only for points that are on single curves of powers."""
    tracks, curves = prepared.tracks, prepared.curves
    out = np.zeros(len(state.location), dtype=bool)
    if not len(out) or prepared.rays_by_component.axis_ratio > ROUND:
        return out
    polynomials = curves.segment_polynomials(state.coefficients)[:, :4]

    def look(chunk: slice) -> None:
        places = slice(int(tracks.starts[chunk.start]), int(tracks.starts[chunk.stop]))
        points = tracks.points[places]
        out[points] = _sure_in_tracks(prepared, state, polynomials, chunk, points)

    in_threads(look, tracks.chunks())
    return out & ~prepared.chains.linked


@dataclass(frozen=True)
class _Hulls:
    """Projected Bezier polygons of segments (g, s)."""

    centre: FloatArray  # (2, g, s)
    radius: FloatArray  # (g, s), inf where part is behind the camera
    reach: FloatArray  # (g, s) distance up to which foot points are unique
    smooth: BoolArray  # (g, s) continues into the next segment without a turn
    whole: FloatArray  # (g,) distance up to which foot points are unique on the whole curve

    @classmethod
    def of(cls, table: FloatArray, count: IntArray) -> _Hulls:
        """Hulls of all columns of a table of segments as images see them, the first `count` (g,) of each row."""
        a = table.reshape(4, 3, len(count), -1)
        thirds = np.stack(
            [a[0], a[0] + a[1] / 3.0, a[0] + (2.0 * a[1] + a[2]) / 3.0, a[0] + a[1] + a[2] + a[3]]
        )
        depth = -thirds[:, 2]
        with np.errstate(all="ignore"):
            b = thirds[:, :2] / -depth[:, None]
            step = np.diff(b, axis=0)
            centre = 0.5 * (b[0] + b[3])
            radius = np.sqrt(((b - centre) ** 2).sum(axis=1).max(axis=0))
            chord = b[3] - b[0]
            unit = chord / np.sqrt((chord**2).sum(axis=0))
            length = np.sqrt((step**2).sum(axis=1))
            along = (step * unit).sum(axis=1)
            straight = (along > STRAIGHT * length).all(axis=0)
            bend = np.sqrt((np.diff(step, axis=0) ** 2).sum(axis=1)).max(axis=0)
            reach = (3.0 * along.min(axis=0)) ** 2 / (REACH * 6.0 * bend)
            even = depth.max(axis=0) <= EVEN_DEPTH * depth.min(axis=0)
            front = (depth > 0.0).all(axis=0)
            joint = (step[2, :, :, :-1] * step[0, :, :, 1:]).sum(axis=0) / (
                length[2, :, :-1] * length[0, :, 1:]
            )
            turn = (unit[:, :, :-1] * unit[:, :, 1:]).sum(axis=0)
            inside = np.arange(a.shape[3]) < count[:, None]
            last = np.take_along_axis(b[3], (count - 1)[None, :, None], axis=2)[:, :, 0]
            way = (last - b[0, :, :, 0]) / np.sqrt(((last - b[0, :, :, 0]) ** 2).sum(axis=0))
            onward = (step * way[:, :, None]).sum(axis=1)
            steady = (((onward > FORWARD * length).all(axis=0) & even & front) | ~inside).all(axis=1)
            steady &= ((joint > 1.0 - SMOOTH) | ~inside[:, 1:]).all(axis=1)
            whole = (
                (3.0 * onward.min(axis=0)) ** 2 / (REACH * 6.0 * bend) + np.where(inside, 0.0, np.inf)
            ).min(axis=1)
        smooth = np.zeros(reach.shape, dtype=bool)
        smooth[:, :-1] = (joint > 1.0 - SMOOTH) & (turn > STRAIGHT)
        reach = np.where(front & even & straight, reach, 0.0)
        return cls(centre, np.where(front, radius, np.inf), reach, smooth, np.where(steady, whole, 0.0))

    def unique(
        self, track: IntArray, place: IntArray, distance: FloatArray, xy: FloatArray, count: IntArray
    ) -> BoolArray:
        """Whether foot points on segments `place`, `distance` from measured points xy (2, k), are the only ones, (k,).

        Parameters
        ----------
        count : (g,) number of segments of every track
        """
        sure = distance < self.reach[track, place]
        for other in range(self.reach.shape[1]):
            away = (place != other) & (other < count[track])
            gap = np.sqrt(((self.centre[:, track, other] - xy) ** 2).sum(axis=0)) - self.radius[track, other]
            joined = (np.abs(place - other) == 1) & self.smooth[track, np.minimum(place, other)]
            joined &= distance < self.reach[track, other]
            sure &= (gap > distance) | joined | ~away
        return np.asarray(sure)


def _sure_in_tracks(
    prepared: Prepared, state: State, polynomials: FloatArray, chunk: slice, points: IntArray
) -> BoolArray:
    tracks, curves = prepared.tracks, prepared.curves
    image, curve = tracks.image[chunk], tracks.curve[chunk]
    begin, count = curves.segment_start[curve], np.diff(curves.segment_start)[curve]
    usable = (count <= WHOLE) & ~curves.trigonometric[begin] & ~curves.closed[curve]
    if not usable.any():
        return np.zeros(len(points), dtype=bool)
    longest = int(count[usable].max())
    every = np.arange(longest)
    segments = begin[:, None] + np.minimum(every, np.minimum(count, longest)[:, None] - 1)
    table = photo_polynomials(polynomials, prepared.principal_distance, state, image, segments)
    hulls = _Hulls.of(table, np.minimum(count, longest))
    track = (
        tracks.of_place[slice(int(tracks.starts[chunk.start]), int(tracks.starts[chunk.stop]))] - chunk.start
    )
    own_curve = prepared.network.curve_observations.curve[points]
    segment, t = curves.locate(own_curve, state.location[points])
    place = np.minimum(segment - begin[track], longest - 1)
    rays = prepared.rays_by_component[points]
    with np.errstate(all="ignore"):
        places = places_on_segments(table, track * longest + place, t)
        off = places.value[:2] / places.value[2] - rays.xy
        distance = np.sqrt((off**2).sum(axis=0))
        possible = usable[track] & (_along(places, rays, off) < FOOT) & (t >= -BEYOND) & (t <= 1.0 + BEYOND)
        sure = possible & (distance < hulls.whole[track])
        rest = np.flatnonzero(possible & ~sure)
        sure[rest] = hulls.unique(track[rest], place[rest], distance[rest], rays.xy[:, rest], count)
    return np.asarray(sure)


def _along(places: CurvePlaces, rays: MeasuredRays, off: FloatArray) -> FloatArray:
    """Residual along the curve in sigma, absolute, (n,)."""
    slope = (places.first[:2] - (off + rays.xy) * places.first[2]) / places.value[2]
    r, b = rays.whitened(off), rays.whitened(slope)
    return np.asarray(np.abs(r[0] * b[0] + r[1] * b[1]) / np.sqrt(b[0] ** 2 + b[1] ** 2))
