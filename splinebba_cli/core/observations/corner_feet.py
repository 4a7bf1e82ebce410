"""Foot points at corners: where a curve is only C0, the nearest place may be the corner itself.

On the outside of a corner the squared distance falls towards it from both sides,

    r . r'(u-) <= 0 <= r . r'(u+),      r = W (p(u) - xy),

and is stationary nowhere near: Newton's method jumps from one side to the other for ever.  Such a point is put on the
corner and its location held there: it measures the corner in both coordinates.  Otherwise a side towards which
the distance falls has the foot point.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.projected_places import newton_step, projected_derivatives
from splinebba_cli.core.state import Prepared, State

UNSETTLED = 1e-6  # sigma along the curve, above which a location is no foot point
BESIDE = 1e-9  # of a segment, from its corner


def at_corners(prepared: Prepared, location: FloatArray) -> BoolArray:
    """Measured points whose location is a corner of their curve, (n,)."""
    if not prepared.corners.any():
        return np.zeros(len(location), dtype=bool)
    curves = prepared.curves
    segment, _ = curves.locate(prepared.network.curve_observations.curve, location)
    return np.asarray(
        prepared.corners[segment] & (location == curves.left[segment]) & ~prepared.chains.linked
    )


def settle_at_corners(
    prepared: Prepared, state: State, polynomials: FloatArray, free: BoolArray, location: FloatArray, steps: int
) -> None:  # fmt: skip
    """Foot points of free points beside corners that Newton's method on the whole curve has not found, in place.

    Parameters
    ----------
    polynomials : (S, K, 3) of the present segments
    free : (n,) measured points that have a location of their own
    location : (n,)
    """
    if not prepared.corners.any():
        return
    rows, corner = _unsettled(prepared, state, polynomials, free, location)
    curves, present = prepared.curves, location[rows]
    at = curves.left[corner]
    back, on = at - BESIDE * curves.length[corner - 1], at + BESIDE * curves.length[corner]
    falls_back = _slope(prepared, state, polynomials, rows, back) > 0.0
    falls_on = _slope(prepared, state, polynomials, rows, on) < 0.0
    both = falls_back & falls_on
    falls_back, falls_on = falls_back & ~(both & (present >= at)), falls_on & ~(both & (present < at))
    location[rows] = at
    start, end = _piece_ends(prepared, rows, corner)
    for moving, low, high in ((falls_back, start, back), (falls_on, on, end)):
        own = rows[moving]
        location[own] = np.clip(present, low, high)[moving]
        for _ in range(steps if len(own) else 0):
            found, _ = newton_step(prepared, state, polynomials, own, location[own])
            location[own] = np.clip(found, low[moving], high[moving])


def _unsettled(
    prepared: Prepared, state: State, polynomials: FloatArray, free: BoolArray, location: FloatArray
) -> tuple[IntArray, IntArray]:
    """Points whose location is no foot point, and the corner that begins or ends their segment, (k,) each.

    A corner is given by the segment that begins at it.
    """
    curves, corners = prepared.curves, prepared.corners
    segment, t = curves.locate(prepared.network.curve_observations.curve, location)
    ends = np.append(corners[1:], False)
    rows = np.flatnonzero(free & (corners | ends)[segment])
    segment, t = segment[rows], t[rows]
    r, r1, _, _ = projected_derivatives(prepared, state, polynomials, rows, location[rows])
    along = np.abs(np.sum(r * r1, axis=1)) / np.maximum(np.linalg.norm(r1, axis=1), 1e-300)
    behind = corners[segment] & ((t < 0.5) | ~ends[segment])
    unsettled = along > UNSETTLED
    return rows[unsettled], np.where(behind, segment, segment + 1)[unsettled]


def _slope(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> FloatArray:
    """r . r' of points at given locations, (k,)."""
    r, r1, _, _ = projected_derivatives(prepared, state, polynomials, rows, location)
    return np.asarray(np.sum(r * r1, axis=1))


def _piece_ends(prepared: Prepared, rows: IntArray, corner: IntArray) -> tuple[FloatArray, FloatArray]:
    """Begin of the smooth piece before the corner of each point, and end of the one after it, (k,) locations."""
    curves, (low, high) = prepared.curves, prepared.location_bounds
    curve = curves.owner[corner]
    begins = np.flatnonzero(prepared.corners)
    place = np.searchsorted(begins, corner)
    before, after = begins[np.maximum(place - 1, 0)], begins[np.minimum(place + 1, len(begins) - 1)]
    has_before = (place > 0) & (curves.owner[before] == curve)
    has_after = (place < len(begins) - 1) & (curves.owner[after] == curve)
    return (
        np.where(has_before, curves.left[before], low[rows]),
        np.where(has_after, curves.left[after], high[rows]),
    )
