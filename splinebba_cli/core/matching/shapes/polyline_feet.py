"""Foot points on polylines in space, many points at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.network import BoolArray, FloatArray


@dataclass(frozen=True)
class Feet:
    """Nearest places of a polyline; all arrays (n,) or (n, 3)."""

    place: FloatArray  # 0 .. k - 1 (closed: k): 2.5 lies half way between vertices 2 and 3
    offset: FloatArray  # point minus foot
    tangent: FloatArray  # unit, of the polyline
    beside: BoolArray  # the foot is no end of an open polyline


def feet_on_polyline(vertices: FloatArray, points: FloatArray, *, closed: bool = False) -> Feet:
    """Foot points on a polyline: in the two segments beside the nearest vertex.

    Parameters
    ----------
    vertices : (k, 3) metres, two or more, in order
    points : (n, 3) metres
    closed : whether the last vertex is followed by the first
    """
    ring = np.vstack([vertices, vertices[:1]]) if closed else vertices
    count = len(ring) - 1
    nearest = cKDTree(vertices).query(points)[1]
    best = np.full(len(points), np.inf)
    place, offset = np.zeros(len(points)), np.zeros((len(points), 3))
    tangent, beside = np.zeros((len(points), 3)), np.zeros(len(points), dtype=bool)
    for side in (-1, 0):
        segment = (nearest + side) % count if closed else np.clip(nearest + side, 0, count - 1)
        begin, step = ring[segment], ring[segment + 1] - ring[segment]
        square = np.maximum(np.sum(step * step, axis=1), 1e-300)
        raw = np.sum((points - begin) * step, axis=1) / square
        t = np.clip(raw, 0.0, 1.0)
        off = points - begin - t[:, None] * step
        distance = np.linalg.norm(off, axis=1)
        ends = (raw < 0.0) & (segment == 0) | (raw > 1.0) & (segment == count - 1)
        nearer = (distance < best) & ((square > 1e-300) | np.isinf(best))
        best = np.where(nearer, distance, best)
        place = np.where(nearer, segment + t, place)
        offset = np.where(nearer[:, None], off, offset)
        tangent = np.where(nearer[:, None], step / np.sqrt(square)[:, None], tangent)
        beside = np.where(nearer, ~ends | closed, beside)
    return Feet(place, offset, tangent, beside)


def cumulated_length(vertices: FloatArray, *, closed: bool = False) -> FloatArray:
    """Length of a polyline up to every vertex, (k,) metres; closed: (k + 1,) with the whole turn."""
    ring = np.vstack([vertices, vertices[:1]]) if closed else vertices
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
