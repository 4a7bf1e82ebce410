"""Foot points of measured points on pieces of projected curves, and which of them are those of whole curves.

A minimum inside a piece is one of the curve.  At the end of a piece there is one where the distance falls towards it on
both sides (a corner, or a root that rounding puts on neither side), or where the curve ends.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from splinebba_cli.core.curves.bernstein import value_and_slope
from splinebba_cli.core.curves.cubic_spans import CubicSpans
from splinebba_cli.core.curves.foot_polynomials import PhotoStationarity
from splinebba_cli.core.curves.rising_roots import Minima
from splinebba_cli.core.matching.candidates.projected_pieces import ProjectedPieces
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

JOINT = 1e-9  # of a segment: nearer to the end of a piece a minimum may be found on both sides


@dataclass(frozen=True)
class PieceFeet:
    """Minima of the distance on pieces."""

    point: IntArray  # (k,)
    segment: IntArray  # (k,)
    t: FloatArray  # (k,) of the segment
    end: IntArray  # (k,) -1: the distance rises from here on; 1: it falls to here; 0: a minimum of the curve
    by_joint: BoolArray  # (k,) at an end of the piece, or next to it
    offset: FloatArray  # (2, k) projected curve minus measured point, mm
    rate: FloatArray  # (2, k) mm per unit of t of the segment
    depth: FloatArray  # (k,) metres

    def __getitem__(self, rows: IntArray | BoolArray) -> PieceFeet:
        """Some of the rows."""
        return PieceFeet(*(getattr(self, each.name)[..., rows] for each in fields(self)))

    @classmethod
    def joined(cls, parts: list[PieceFeet]) -> PieceFeet:
        """All of some."""
        columns = ([getattr(part, each.name) for part in parts] for each in fields(cls))
        return cls(*(np.concatenate(column, axis=-1) for column in columns))


def piece_feet(
    pieces: ProjectedPieces,
    spans: CubicSpans,
    piece: IntArray,
    point: IntArray,
    measured: FloatArray,
    radius: FloatArray,
) -> PieceFeet:
    """Minima of the distance of points from pieces, not farther than a radius.

    Parameters
    ----------
    piece, point : (k,) pairs
    measured : (2, k) mm, of the points
    radius : (k,) mm
    """
    used, column = np.unique(piece, return_inverse=True)
    bezier = pieces.bezier[:, :, used]
    stationarity = PhotoStationarity.of(bezier[:, :2], bezier[:, 2])
    minima = Minima.of(stationarity.at(column, measured))
    row, t = minima.column, minima.t
    place, rate = value_and_slope(bezier[:, :, column[row]], t)
    depth = place[2]
    with np.errstate(all="ignore"):
        xy = place[:2] / depth
        rate = (rate[:2] - xy * rate[2]) / depth
        offset = xy - measured[:, row]
        near = (depth > 0.0) & (offset[0] * offset[0] + offset[1] * offset[1] <= radius[row] ** 2)
    row, t, end = row[near], t[near], minima.end[near]
    own = piece[row]
    span = pieces.span[own]
    width = pieces.width[own] * spans.width[span]
    by_joint = (end != 0) | (np.minimum(t, 1.0 - t) * width < JOINT)
    t = spans.begin[span] + spans.width[span] * pieces.begin[own] + width * t
    return PieceFeet(
        point[row], spans.segment[span], t, end, by_joint, offset[:, near], rate[:, near] / width, depth[near]
    )
