"""Curves as images see them, cut into pieces so small that few points are near each of them.

A cubic span seen in a photo is a rational cubic Q(t) / D(t) (foot_polynomials.py) with Bezier points P_i = Q_i / D_i.
Where all D_i are positive, the piece lies in the hull of its P_i, hence

- in their box, and
- within the deviation of P_1 and P_2 from the chord P_0 P_3 of that chord.

A point from which a curve is at most r away is therefore in the box of one of its pieces, enlarged by r, and at most
r + deviation from its chord.  What lies outside of a half plane of the photo, or behind the camera, does so with all
(Q_i, D_i), also where signs of D differ; pieces that cross the plane of the perspective centre are cut until they are
outside, or as often as DEEPEST: then they may be anywhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.bernstein import halves
from splinebba_cli.core.curves.cubic_spans import CubicSpans
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

DEEPEST = 20  # halvings of a span


@dataclass(frozen=True)
class Window:
    """The part of photos that matters: where points are, and how far from them curves may be."""

    low: FloatArray  # (2, m) mm
    high: FloatArray  # (2, m)
    size: FloatArray  # (m,) of boxes of pieces

    @property
    def reach(self) -> FloatArray:
        """Largest absolute coordinate, (m,)."""
        return np.asarray(np.maximum(np.abs(self.low), np.abs(self.high)).max(axis=0))


@dataclass(frozen=True)
class ProjectedPieces:
    """Pieces of spans before images."""

    image: IntArray  # (k,)
    span: IntArray  # (k,)
    begin: FloatArray  # (k,) of the span, which is [0, 1]
    width: FloatArray  # (k,)
    bezier: FloatArray  # (4, 3, k) Q and D
    low: FloatArray  # (2, k) box, mm
    high: FloatArray  # (2, k)
    chord: FloatArray  # (2, 2, k) P_0 and P_3
    deviation: FloatArray  # (k,) mm from the chord; inf: unknown
    extent: FloatArray  # (k,) longer side of the box, without the error of the span

    def __len__(self) -> int:
        return len(self.image)

    def __getitem__(self, rows: IntArray | BoolArray) -> ProjectedPieces:
        """Some of the pieces."""
        return ProjectedPieces(
            self.image[rows], self.span[rows], self.begin[rows], self.width[rows], self.bezier[:, :, rows],
            self.low[:, rows], self.high[:, rows], self.chord[:, :, rows], self.deviation[rows],
            self.extent[rows],
        )  # fmt: skip


@dataclass(frozen=True)
class _Parts:
    """Pieces under way."""

    image: IntArray
    span: IntArray
    begin: FloatArray
    bezier: FloatArray
    slack: FloatArray  # metres, error of the span

    def __getitem__(self, rows: BoolArray) -> _Parts:
        return _Parts(
            self.image[rows], self.span[rows], self.begin[rows], self.bezier[:, :, rows], self.slack[rows]
        )


def projected_pieces(
    scene: Scene, spans: CubicSpans, window: Window, image: IntArray, span: IntArray
) -> ProjectedPieces:
    """Pieces of spans that images can see in their windows.

    Parameters
    ----------
    image, span : (k,) which spans before which images
    """
    parts = _Parts(
        image, span, np.zeros(len(image)), _seen(scene, spans.points[:, :, span], image), spans.error[span]
    )
    done: list[ProjectedPieces] = []
    for depth in range(DEEPEST + 1):
        parts = parts[~_outside(parts, window, scene.principal_distance)]
        pieces = _with_hulls(parts, window, scene.principal_distance, 0.5**depth)
        final = (pieces.extent <= window.size[parts.image]) | (depth == DEEPEST)
        done.append(pieces[final])
        parts = parts[~final]
        if not len(parts.image):
            break
        left, right = halves(parts.bezier)
        parts = _Parts(
            np.tile(parts.image, 2), np.tile(parts.span, 2),
            np.concatenate([parts.begin, parts.begin + 0.5 ** (depth + 1)]),
            np.concatenate([left, right], axis=2), np.tile(parts.slack, 2),
        )  # fmt: skip
    return _joined(done)


def _seen(scene: Scene, points: FloatArray, image: IntArray) -> FloatArray:
    """Q and D of Bernstein coefficients of spans (4, 3, k) before images, (4, 3, k)."""
    local = points - scene.position[image].T
    turn = np.ascontiguousarray(scene.rotation.transpose(1, 2, 0))[:, :, image]
    c = scene.principal_distance[image]
    out = np.empty_like(local)
    for axis, factor in enumerate((c, c, np.full(len(c), -1.0))):
        total = local[:, 0] * turn[0, axis]
        total += local[:, 1] * turn[1, axis]
        total += local[:, 2] * turn[2, axis]
        out[:, axis] = total * factor
    return out


def _outside(parts: _Parts, window: Window, distance: FloatArray) -> BoolArray:
    """Whether parts are certainly outside of the window or behind the camera, (k,)."""
    image, depth = parts.image, parts.bezier[:, 2]
    slack = parts.slack * (distance + window.reach)[image]
    most = _largest(depth) + parts.slack
    out = most <= 0.0
    for axis in range(2):
        value = parts.bezier[:, axis]
        out |= _largest(value - window.low[axis, image] * depth) < -slack
        out |= _largest(window.high[axis, image] * depth - value) < -slack
    return np.asarray(out)


def _largest(rows: FloatArray) -> FloatArray:
    """The largest of four numbers, (4, ...): faster than a maximum along a short axis."""
    return np.asarray(np.maximum(np.maximum(rows[0], rows[1]), np.maximum(rows[2], rows[3])))


def _with_hulls(parts: _Parts, window: Window, distance: FloatArray, width: float) -> ProjectedPieces:
    """Boxes and chords; those of parts that are not wholly in front of the camera are the whole window."""
    image = parts.image
    depth = parts.bezier[:, 2]
    nearest = -_largest(-depth)
    front = nearest > 2.0 * parts.slack
    with np.errstate(all="ignore"):
        p = np.where(front, parts.bezier[:, :2] / depth[:, None], 0.0)
        low, high = -_largest(-p), _largest(p)
        reach = np.maximum(_largest(np.concatenate([high, -low])), 0.0)
        slack = np.where(front, parts.slack * (distance[image] + reach) / (nearest - parts.slack), 0.0)
    bend = np.maximum(distance_to_chords(p[1], p[0], p[3]), distance_to_chords(p[2], p[0], p[3]))
    return ProjectedPieces(
        image, parts.span, parts.begin, np.full(len(image), width), parts.bezier,
        np.where(front, low - slack, window.low[:, image]), np.where(front, high + slack, window.high[:, image]),
        np.stack([p[0], p[3]]), np.where(front, bend + slack, np.inf),
        np.where(front, np.maximum(high[0] - low[0], high[1] - low[1]), np.inf),
    )  # fmt: skip


def distance_to_chords(place: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    """Distances of places from straight chords, all (2, k): (k,)."""
    way, off = last - first, place - first
    square = way[0] * way[0] + way[1] * way[1]
    with np.errstate(all="ignore"):
        t = (off[0] * way[0] + off[1] * way[1]) / square
    t = np.clip(np.where(square > 0.0, t, 0.0), 0.0, 1.0)
    off -= t * way
    return np.asarray(np.sqrt(off[0] * off[0] + off[1] * off[1]))


def _joined(pieces: list[ProjectedPieces]) -> ProjectedPieces:
    """All of some."""
    if len(pieces) == 1:
        return pieces[0]
    return ProjectedPieces(
        *(np.concatenate([getattr(each, name) for each in pieces], axis=-1) for name in _FIELDS)
    )


_FIELDS = ("image", "span", "begin", "width", "bezier", "low", "high", "chord", "deviation", "extent")
