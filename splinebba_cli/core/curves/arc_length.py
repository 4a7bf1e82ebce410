"""Nodes and weights for integrals along curves, L = int f(u) du between two locations.

    simpson          one step, L = h/6 [f(u1) + 4 f(um) + f(u2)] (Lee 3.38)
    gauss_legendre   ten nodes on every piece between joints

Weights and nodes depend on the ends; both derivatives are given, so that the derivatives of the sum are exact.
Open curves continue their end segments beyond their ends.  On a closed curve the way from u1 to u2 may pass the
start of the domain: ends are then given unwrapped, u2 - u1 up to one period.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(10)
SIMPSON_NODES, SIMPSON_WEIGHTS = np.array([-1.0, 0.0, 1.0]), np.array([1.0, 4.0, 1.0]) / 3.0


@dataclass(frozen=True)
class QuadratureNodes:
    """All nodes of many integrals; L_k = sum over the nodes of interval k of weight * f."""

    interval: IntArray  # (K,) which integral
    segment: IntArray  # (K,) segment number in the curve set
    t: FloatArray  # (K,) inside the segment
    weight: FloatArray  # (K,) in units of u
    weight_slopes: FloatArray  # (K, 2) d weight / d(low, high)
    node_slopes: FloatArray  # (K, 2) d u / d(low, high)


def quadrature_nodes(
    curves: CurveSet, curve: IntArray, low: FloatArray, high: FloatArray, simpson: BoolArray
) -> QuadratureNodes:
    """Nodes of integrals from `low` to `high`, low <= high.

    Parameters
    ----------
    curve : (k,) int
    low, high : (k,) float, unwrapped locations
    simpson : (k,) bool, which rule
    """
    whole = np.flatnonzero(simpson)
    split = np.flatnonzero(~simpson)
    parts = [
        _nodes(curves, curve, whole, low[whole], high[whole], (SIMPSON_NODES, SIMPSON_WEIGHTS)),
        _piecewise(curves, curve, split, low[split], high[split]),
    ]
    return QuadratureNodes(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in QuadratureNodes.__annotations__)
    )


def _nodes(
    curves: CurveSet, curve: IntArray, interval: IntArray, low: FloatArray, high: FloatArray,
    rule: tuple[FloatArray, FloatArray],
) -> QuadratureNodes:  # fmt: skip
    """One rule over each interval; the nodes are located one by one."""
    x, w = rule
    count = len(x)
    half = 0.5 * (high - low)
    u = (0.5 * (low + high))[:, None] + half[:, None] * x
    segment, t = curves.locate(np.repeat(curve[interval], count), u.ravel())
    return QuadratureNodes(
        interval=np.repeat(interval, count),
        segment=segment,
        t=t,
        weight=(half[:, None] * w).ravel(),
        weight_slopes=np.tile(0.5 * w[:, None] * [-1.0, 1.0], (len(interval), 1)),
        node_slopes=np.tile(np.stack([0.5 * (1.0 - x), 0.5 * (1.0 + x)], axis=1), (len(interval), 1)),
    )


def _piecewise(
    curves: CurveSet, curve: IntArray, interval: IntArray, low: FloatArray, high: FloatArray
) -> QuadratureNodes:
    """Gauss-Legendre on every piece between joints."""
    curve = curve[interval]
    first, count = curves.segment_start[curve], np.diff(curves.segment_start)[curve]
    period = curves.last[curve] - curves.first[curve]
    start = _unwrapped_segment(curves, curve, low)
    pieces = _unwrapped_segment(curves, curve, high) - start + 1
    which = np.repeat(np.arange(len(curve)), pieces)
    number = np.arange(len(which)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    turn, local = np.divmod(start[which] + number, count[which])
    segment = first[which] + local
    edge = curves.left[segment] + turn * period[which]
    is_first, is_last = number == 0, number == pieces[which] - 1
    a = np.where(is_first, low[which], edge)
    b = np.where(is_last, high[which], edge + curves.length[segment])
    x, w = GAUSS_NODES, GAUSS_WEIGHTS
    half = 0.5 * (b - a)
    u = (0.5 * (a + b))[:, None] + half[:, None] * x
    t = (u - edge[:, None]) / curves.length[segment][:, None]
    moves = np.stack([is_first, is_last], axis=1)[:, None, :]  # which ends of a piece move with the interval
    weight_slopes = 0.5 * w[None, :, None] * np.array([-1.0, 1.0]) * moves
    node_slopes = 0.5 * np.stack([1.0 - x, 1.0 + x], axis=1)[None] * moves
    return QuadratureNodes(
        interval=np.repeat(interval[which], len(x)),
        segment=np.repeat(segment, len(x)),
        t=t.ravel(),
        weight=(half[:, None] * w).ravel(),
        weight_slopes=weight_slopes.reshape(-1, 2),
        node_slopes=node_slopes.reshape(-1, 2),
    )


def _unwrapped_segment(curves: CurveSet, curve: IntArray, u: FloatArray) -> IntArray:
    """Segment of unwrapped locations, counted from the first of the curve and on through further turns."""
    segment, _ = curves.locate(curve, u)
    local = segment - curves.segment_start[curve]
    period = curves.last[curve] - curves.first[curve]
    turn = np.floor((u - curves.first[curve]) / period).astype(np.int64)
    count = np.diff(curves.segment_start)[curve]
    return np.where(curves.closed[curve], local + turn * count, local)
