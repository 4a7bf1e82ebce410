"""Which curves pass near a measured point, and where: every nearest place inside a radius.

Curves are cut into small pieces with hulls (projected_pieces.py); the points near a hull come from a grid
(point_grid.py); on each piece all minima of the distance are found (piece_feet.py).  A point that is at most its radius
away from a place of a curve lies in the enlarged hull of the piece with that place, so that none is lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.cubic_spans import CubicSpans
from splinebba_cli.core.matching.candidates.curve_feet import settled_on_curves, whole_curve_feet
from splinebba_cli.core.matching.candidates.piece_feet import PieceFeet, piece_feet
from splinebba_cli.core.matching.candidates.point_grid import PointGrid, expand
from splinebba_cli.core.matching.candidates.projected_pieces import (
    ProjectedPieces,
    Window,
    distance_to_chords,
    projected_pieces,
)
from splinebba_cli.core.matching.candidates.span_groups import SpanGroups
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.threads import in_threads
from splinebba_cli.core.tracks import chunks_of

SPANS_AT_ONCE = 5_000
PAIRS_AT_ONCE = 100_000
RADII = 2.0  # side of a cell, in the widest radius
BOX = 4.0  # side of the boxes of pieces, in cells


@dataclass(frozen=True)
class Candidates:
    """Pairs of a point and a place on a curve near it, sorted by point, nearest first.

    The distance has a local minimum there: `offset` is perpendicular to `tangent` but at ends and corners.
    """

    point: IntArray  # (k,)
    curve: IntArray  # (k,)
    location: FloatArray  # (k,) u of the foot point
    offset: FloatArray  # (k, 2) projected curve minus measured point, mm in the corrected photo
    tangent: (
        FloatArray  # (k, 2) unit direction of the projected curve, in the sense of ascending u; NaN: none
    )
    segment: IntArray  # (k,) of all curves
    speed: FloatArray  # (k,) mm per unit of u
    depth: FloatArray  # (k,) metres, -w of the foot point
    at_end: BoolArray  # (k,) an open curve ends here
    at_corner: BoolArray  # (k,) both sides of a corner lead away

    def __len__(self) -> int:
        return len(self.point)


@dataclass(frozen=True)
class _Search:
    """What all parts of the search share."""

    scene: Scene
    spans: CubicSpans
    window: Window
    grid: PointGrid
    groups: SpanGroups
    radius: FloatArray  # (n,) of every point
    widest: FloatArray  # (m,) of the points of an image

    @classmethod
    def of(cls, scene: Scene, radius: FloatArray, points: IntArray) -> _Search:
        spans = CubicSpans.of(scene.curves, scene.polynomials)
        count = len(scene.position)
        widest = np.zeros(count)
        np.maximum.at(widest, scene.image[points], radius[points])
        widest = widest * (1.0 + 1e-9) + 1e-12
        grid = PointGrid.of(scene.image, scene.xy, RADII * widest, points)
        low, high = grid.frame
        window = Window(low - widest, high + widest, BOX * grid.cell)
        return cls(scene, spans, window, grid, SpanGroups.of(spans, scene.curves), radius, widest)

    def feet(self, image: IntArray, group: IntArray) -> PieceFeet:
        """Minima on groups of spans before images."""
        which, span = self.groups.spans(group)
        pieces = projected_pieces(self.scene, self.spans, self.window, image[which], span)
        own = self.widest[pieces.image]
        box, begin, end = self.grid.ranges(pieces.image, pieces.low - own, pieces.high + own)
        starts = np.concatenate([[0], np.cumsum(end - begin)])
        found = [
            self._near(pieces, box[part], begin[part], end[part]) for part in chunks_of(starts, PAIRS_AT_ONCE)
        ]
        none = np.zeros(0, dtype=np.int64)
        return PieceFeet.joined(found) if found else self._near(pieces, none, none, none)

    def _near(self, pieces: ProjectedPieces, box: IntArray, begin: IntArray, end: IntArray) -> PieceFeet:
        """Minima of points in ranges of places of the grid, on the pieces to which the ranges belong."""
        owner, place = expand(begin, end)
        piece, point = box[owner], self.grid.points[place]
        measured, radius = self.scene.xy[point].T, self.radius[point]
        reach = radius * (1.0 + 1e-9) + 1e-12 + pieces.deviation[piece]
        chord = pieces.chord[:, :, piece]
        near = np.flatnonzero(distance_to_chords(measured, chord[0], chord[1]) <= reach)
        piece, point = piece[near], point[near]
        return piece_feet(pieces, self.spans, piece, point, measured[:, near], radius[near])


def find_candidates(scene: Scene, radius: FloatArray, points: IntArray | None = None) -> Candidates:
    """Foot points in the image on all curves that pass within a radius of measured points.

    Curves, images and points that are not known (NaN) and curves without locations have none.  Memory grows with the
    number of candidates: where radii are so large that points have dozens of them, look at points in parts.

    Parameters
    ----------
    radius : (n,) finite, mm, of every point of the scene
    points : (k,) points that are looked at, default all

    Returns
    -------
    Candidates
        One for every curve and every branch of it that has a local minimum of the distance inside the radius.
    """
    points = np.arange(len(scene.image)) if points is None else points
    oriented = scene.rotation.sum(axis=(1, 2)) + scene.position.sum(axis=1)
    known: BoolArray = np.isfinite(oriented[scene.image[points]] + scene.xy[points].sum(axis=1))
    search = _Search.of(scene, radius, points[known])
    images = np.unique(scene.image[search.grid.points])
    image, group = search.groups.seen(scene, search.window, images)
    number = search.groups.last[group] - search.groups.first[group]
    parts = chunks_of(np.concatenate([[0], np.cumsum(number)]), SPANS_AT_ONCE)
    found = in_threads(lambda part: search.feet(image[part], group[part]), parts)
    if not found:
        found = [search.feet(image[:0], group[:0])]
    feet, corner = whole_curve_feet(scene.curves, PieceFeet.joined(found))
    return _sorted(scene, settled_on_curves(scene, feet), corner)


def _sorted(scene: Scene, feet: PieceFeet, corner: BoolArray) -> Candidates:
    order = np.lexsort((np.sum(feet.offset**2, axis=0), feet.point))
    feet, corner = feet[order], corner[order]
    curves = scene.curves
    curve = curves.owner[feet.segment]
    speed = np.sqrt(np.sum(feet.rate**2, axis=0))
    with np.errstate(all="ignore"):
        tangent = feet.rate / speed
    length = curves.length[feet.segment]
    return Candidates(
        point=feet.point,
        curve=curve,
        location=curves.left[feet.segment] + length * feet.t,
        offset=feet.offset.T,
        tangent=tangent.T,
        segment=feet.segment,
        speed=speed / length,
        depth=feet.depth,
        at_end=(feet.end != 0) & ~corner,
        at_corner=corner,
    )
