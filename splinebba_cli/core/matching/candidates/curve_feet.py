"""Foot points on whole curves from those on their pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.collinearity import photo_frame_xyz
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.matching.candidates.piece_feet import JOINT, PieceFeet
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

STEPS = 8  # of Newton's method, from foot points on cubics that hardly differ from the curve
PERPENDICULAR = 1e-6  # cosine


def whole_curve_feet(curves: CurveSet, feet: PieceFeet) -> tuple[PieceFeet, BoolArray]:
    """Minima of the distance from whole curves, and whether each lies in a corner, (k,).

    Rows that were found from two sides are one; a row that leads to the end of a piece or away from it stays where
    another one does so from the other side, or where the curve ends.
    """
    inner = np.flatnonzero(~feet.by_joint)
    joint = np.flatnonzero(feet.by_joint)
    kept = _joined_at_joints(curves, feet[joint])
    rows = np.concatenate([inner, joint[kept]])
    feet = feet[rows]
    curve = curves.owner[feet.segment]
    place = feet.segment + feet.t
    ends = ~curves.closed[curve] & (
        (place <= curves.segment_start[curve]) | (place >= curves.segment_start[curve + 1])
    )
    along = np.abs(np.sum(feet.offset * feet.rate, axis=0))
    oblique = along > PERPENDICULAR * np.sqrt(np.sum(feet.offset**2, axis=0) * np.sum(feet.rate**2, axis=0))
    end = np.where(ends, feet.end, 0)
    return replace(feet, end=end), (feet.end != 0) & ~ends & oblique


def _joined_at_joints(curves: CurveSet, feet: PieceFeet) -> IntArray:
    """Rows that stay of those beside joints of pieces."""
    if not len(feet.point):
        return np.zeros(0, dtype=np.int64)
    curve = curves.owner[feet.segment]
    begin, end = curves.segment_start[curve], curves.segment_start[curve + 1]
    place = feet.segment + feet.t
    place = np.where(curves.closed[curve] & (place > end - JOINT), begin + (place - end), place)
    order = np.lexsort((place, curve, feet.point))
    place, point, owner, kind = place[order], feet.point[order], curve[order], feet.end[order]
    first = np.append(
        True, (point[1:] != point[:-1]) | (owner[1:] != owner[:-1]) | (np.diff(place) > 2.0 * JOINT)
    )
    starts = np.flatnonzero(first)
    inside = np.logical_or.reduceat(kind == 0, starts)
    both = np.logical_or.reduceat(kind < 0, starts) & np.logical_or.reduceat(kind > 0, starts)
    only = place[starts]
    open_end = ~curves.closed[owner[starts]] & (
        (only <= begin[order][starts] + JOINT) | (only >= end[order][starts] - JOINT)
    )
    # of each joint one row: a minimum inside a piece before all others
    cluster = np.cumsum(first) - 1
    best = np.lexsort((kind != 0, cluster))
    chosen = best[np.append(True, np.diff(cluster[best]) > 0)]
    return np.asarray(order[chosen[inside | both | open_end]])


def settled_on_curves(scene: Scene, feet: PieceFeet) -> PieceFeet:
    """The feet moved from spans to the curves themselves, where these are no cubics."""
    rows = np.flatnonzero(scene.curves.trigonometric[feet.segment])
    if not len(rows):
        return feet
    own = feet[rows]
    t = own.t
    for _ in range(STEPS):
        step = _newton_step(*_seen(scene, own, t)[:3])
        t = np.clip(t + np.where(own.end == 0, step, 0.0), 0.0, 1.0)
    offset, rate, _, depth = _seen(scene, own, t)
    new = {name: getattr(feet, name).copy() for name in ("t", "offset", "rate", "depth")}
    for name, value in (("t", t), ("offset", offset), ("rate", rate), ("depth", depth)):
        new[name][..., rows] = value
    return replace(feet, **new)


def _seen(
    scene: Scene, feet: PieceFeet, t: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Offsets, rates and second derivatives in the photo (2, k), in t, and depths (k,)."""
    image, length = scene.image[feet.point], scene.curves.length[feet.segment]
    turn, c = scene.rotation[image], scene.principal_distance[image]
    x, x1, x2 = scene.curves.derivatives(scene.polynomials, feet.segment, t)
    p = photo_frame_xyz(turn, scene.position[image], x).T
    p1 = np.einsum("nji,nj->in", turn, x1 * length[:, None])
    p2 = np.einsum("nji,nj->in", turn, x2 * (length**2)[:, None])
    depth = -p[2]
    xy = c * p[:2] / depth
    rate = (c * p1[:2] + xy * p1[2]) / depth
    bend = (c * p2[:2] + xy * p2[2] + 2.0 * rate * p1[2]) / depth
    return xy - scene.xy[feet.point].T, rate, bend, depth


def _newton_step(offset: FloatArray, rate: FloatArray, bend: FloatArray) -> FloatArray:
    """Step of t towards the stationary distance, (k,); 0 where it is no minimum."""
    curvature = np.sum(rate * rate, axis=0) + np.sum(offset * bend, axis=0)
    with np.errstate(all="ignore"):
        step = -np.sum(offset * rate, axis=0) / curvature
    return np.where(np.isfinite(step) & (curvature > 0.0), step, 0.0)
