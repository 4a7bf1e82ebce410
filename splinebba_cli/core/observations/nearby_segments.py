"""Which segments of a long curve can be nearest to what an image measures on it.

Groups of segments lie inside spheres; a sphere of radius rho about a point that is seen at x with depth |w| is seen
inside a circle of radius

    (c + |x|) rho / (|w| - rho)

about x.  A group whose circle is farther from a measured point than any place of the curve cannot hold its foot
point, nor can one outside the cone of that distance about the ray (towards the horizon circles tell nothing).  So an
image pays for the part of a coastline that it sees, and little for the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import photo_frame_xyz
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State

GROUP = 8  # segments of one sphere
WHOLE = 16  # segments up to which all of a curve are candidates
PART = 2_000_000  # pairs of tracks and groups that are looked at together


@dataclass(frozen=True)
class SegmentGroups:
    """Spheres around groups of segments of one curve."""

    first: IntArray  # (k,) first segment
    last: IntArray  # (k,) one behind the last
    centre: FloatArray  # (k, 3)
    radius: FloatArray  # (k,)

    @classmethod
    def of(cls, prepared: Prepared, polynomials: FloatArray, curve: int) -> SegmentGroups:
        """Groups of a curve of powers."""
        begin, end = (int(s) for s in prepared.curves.segment_start[curve : curve + 2])
        first = np.arange(begin, end, GROUP)
        last = np.minimum(first + GROUP, end)
        a = polynomials[begin:end]
        hull = np.stack(
            [a[:, 0], a[:, 0] + a[:, 1] / 3.0, a[:, 0] + (2.0 * a[:, 1] + a[:, 2]) / 3.0, a.sum(axis=1)]
        )
        low = np.minimum.reduceat(hull.min(axis=0), first - begin)
        high = np.maximum.reduceat(hull.max(axis=0), first - begin)
        return cls(first, last, 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1))


def nearby_segments(
    prepared: Prepared, state: State, polynomials: FloatArray, image: IntArray, curve: IntArray,
    centre: FloatArray, radius: FloatArray,
) -> IntArray:  # fmt: skip
    """Segments that can be nearest to points measured in images on curves, (g, s), padded with -1.

    Parameters
    ----------
    polynomials : (S, K, 3) of the present segments
    image, curve : (g,)
    centre, radius : (g, 2), (g,) circles around the points, mm in the corrected photo
    """
    curves = prepared.curves
    begin, end = curves.segment_start[curve], curves.segment_start[curve + 1]
    count = end - begin
    whole = (count <= WHOLE) | curves.trigonometric[np.minimum(begin, len(curves.left) - 1)]
    lists: list[tuple[IntArray, IntArray]] = []  # rows and segments
    for number in np.unique(curve[~whole]).tolist():
        rows = np.flatnonzero((curve == number) & ~whole)
        groups = SegmentGroups.of(prepared, polynomials[:, :4], number)
        size = max(1, PART // len(groups.first))
        for start in range(0, len(rows), size):
            part = rows[start : start + size]
            lists.append(_near_groups(prepared, state, groups, image[part], part, centre[part], radius[part]))
    widths = np.where(whole, count, 0)
    for rows, _ in lists:
        widths += np.bincount(rows, minlength=len(widths))
    out = np.full((len(image), int(widths.max(initial=0))), -1)
    every = np.arange(out.shape[1])
    inside = whole[:, None] & (every < count[:, None])
    out[inside] = (begin[:, None] + every)[inside]
    for rows, segments in lists:
        place = np.arange(len(rows)) - np.searchsorted(rows, rows)
        out[rows, place] = segments
    return out


def _near_groups(
    prepared: Prepared, state: State, groups: SegmentGroups, image: IntArray, rows: IntArray, centre: FloatArray,
    radius: FloatArray,
) -> tuple[IntArray, IntArray]:  # fmt: skip
    """Rows and segments of the groups that can be near, sorted by row."""
    shape = (len(image), len(groups.first))
    owner = np.repeat(image, shape[1])
    p = photo_frame_xyz(state.rotation[owner], state.position[owner], np.tile(groups.centre, (shape[0], 1)))
    distance = prepared.principal_distance[owner]
    depth = -p[:, 2]
    with np.errstate(all="ignore"):
        xy = distance[:, None] * p[:, :2] / depth[:, None]
        size = (
            (distance + np.linalg.norm(xy, axis=1))
            * np.tile(groups.radius, shape[0])
            / (depth - np.tile(groups.radius, shape[0]))
        )
        apart = np.linalg.norm(xy - np.repeat(centre, shape[1], axis=0), axis=1)
        range_ = np.linalg.norm(p, axis=1)
        towards = np.repeat(np.column_stack([centre, -prepared.principal_distance[image]]), shape[1], axis=0)
        cosine = np.sum(p * towards, axis=1) / (range_ * np.linalg.norm(towards, axis=1))
        reach = np.tile(groups.radius, shape[0])
        aside = np.arccos(np.clip(cosine, -1.0, 1.0)) - np.arcsin(np.minimum(reach / range_, 1.0))
        aside = np.where(reach >= range_, -np.inf, aside).reshape(shape)  # the camera is inside
    seen = (depth > reach).reshape(shape)
    crossing = ~seen & (depth > -reach).reshape(shape)
    apart, size = apart.reshape(shape), size.reshape(shape)
    nearest = np.where(seen, apart + size, np.inf).min(axis=1)
    # nearest in sigma may be farther away in the photo, by the ratio of the axes of the error ellipses
    farthest = prepared.rays_by_component.axis_ratio * (nearest + radius) + radius
    near = (seen & (apart - size <= farthest[:, None])) | crossing
    c, middle = prepared.principal_distance[image], np.linalg.norm(centre, axis=1)
    near &= aside <= (np.arctan2(middle + farthest, c) + np.arctan2(middle, c))[:, None]
    near[~near.any(axis=1)] = True
    row, group = np.nonzero(near)
    number = groups.last[group] - groups.first[group]
    within = np.arange(int(number.sum())) - np.repeat(np.cumsum(number) - number, number)
    return np.repeat(rows[row], number), np.repeat(groups.first[group], number) + within
