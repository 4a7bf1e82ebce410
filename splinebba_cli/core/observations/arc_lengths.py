"""Arc lengths in the image (Lee 3.20-3.39, derivatives corrected; theory, section 4).

    L = int |p'(u)| du from u1 to u2,   p' = (x', y') of the collinearity equations,   (L - measured) / sigma = v

A length has no sense: u2 < u1 gives the same.  On a closed curve the way round is taken whose length is nearer to the
measured one.  Integrals: :mod:`splinebba_cli.core.curves.arc_length`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.arc_length import QuadratureNodes, quadrature_nodes
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_kinematics import CurveKinematics
from splinebba_cli.core.state import Prepared, State

AMBIGUOUS = 0.25  # of the period: a way round this much longer than the other is not looked at


@dataclass(frozen=True)
class ArcRows:
    """Linearised arc lengths, whitened.  Derivatives over coefficients stay with the nodes of the integrals."""

    residual: FloatArray  # (q,)
    slopes: FloatArray  # (q, 2) d/du of the first and of the second point
    orientation: FloatArray  # (q, 6)
    node_arc: IntArray  # (K,) arc of every node
    node_segment: IntArray  # (K,)
    node_coefficients: FloatArray  # (K, w, 3) d/dP_j, to be summed over the nodes of an arc


@dataclass(frozen=True)
class _Integrals:
    """Integrals of the speed at a state."""

    nodes: QuadratureNodes
    at: CurveKinematics
    speed: FloatArray  # (K,)
    unit: FloatArray  # (K, 2) direction of the velocity
    reversed: BoolArray  # (q,) whether the first point is at the upper end

    def sums(self, values: FloatArray) -> FloatArray:
        """Sums over the nodes of every arc, (q,)."""
        return np.asarray(np.bincount(self.nodes.interval, values, minlength=len(self.reversed)), dtype=float)

    def lengths(self) -> FloatArray:
        """Lengths (q,) mm."""
        return self.sums(self.nodes.weight * self.speed)

    def slopes(self) -> FloatArray:
        """Derivatives of the lengths over the locations of the first and second point, (q, 2)."""
        bend = self.nodes.weight * self.at.slope(self.unit)
        both = [
            self.sums(self.nodes.weight_slopes[:, k] * self.speed + bend * self.nodes.node_slopes[:, k])
            for k in range(2)
        ]
        ends = np.stack(both, axis=1)
        return np.where(self.reversed[:, None], ends[:, ::-1], ends)


def linearize_arc_lengths(prepared: Prepared, state: State, rows: IntArray | None = None) -> ArcRows:
    """Equations of arc lengths at a state.

    Parameters
    ----------
    rows : (q,) which arc lengths; default all

    Raises
    ------
    FloatingPointError
        If part of an arc lies behind a camera.
    """
    rows = np.arange(len(prepared.network.arc_lengths)) if rows is None else rows
    found = _integrals(prepared, state, rows)
    nodes, whitening = found.nodes, 1.0 / prepared.arc_lengths.sigma[rows]
    gradient = found.at.gradients(found.unit)
    weight = nodes.weight * whitening[nodes.interval]
    return ArcRows(
        residual=(found.lengths() - prepared.arc_lengths.value[rows]) * whitening,
        slopes=found.slopes() * whitening[:, None],
        orientation=np.stack([found.sums(weight * gradient.orientation[:, k]) for k in range(6)], axis=1),
        node_arc=nodes.interval,
        node_segment=nodes.segment,
        node_coefficients=gradient.coefficients * weight[:, None, None],
    )


def arc_residuals_and_slopes(
    prepared: Prepared, state: State, rows: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Whitened residuals (q,) and their derivatives over both locations (q, 2), parameters held; raises likewise."""
    found, whitening = _integrals(prepared, state, rows), 1.0 / prepared.arc_lengths.sigma[rows]
    residual = (found.lengths() - prepared.arc_lengths.value[rows]) * whitening
    return residual, found.slopes() * whitening[:, None]


def arc_lengths_at(prepared: Prepared, state: State, rows: IntArray) -> FloatArray:
    """Lengths of projected arcs in the corrected photo frame at a state, (q,) mm."""
    return _integrals(prepared, state, rows).lengths()


def _integrals(prepared: Prepared, state: State, rows: IntArray) -> _Integrals:
    nodes, reversed_ = _nodes(prepared, state, rows)
    found = _evaluated(prepared, state, rows, nodes, reversed_)
    if not np.isfinite(found.speed).all():
        raise FloatingPointError("part of an arc length lies behind a camera")
    return found


def _evaluated(
    prepared: Prepared, state: State, rows: IntArray, nodes: QuadratureNodes, reversed_: BoolArray
) -> _Integrals:
    image = prepared.network.curve_observations.image[prepared.network.arc_lengths.first[rows]]
    at = CurveKinematics.at(prepared, state, image[nodes.interval], nodes.segment, nodes.t)
    velocity = at.velocity()
    speed = np.hypot(velocity[:, 0], velocity[:, 1])
    return _Integrals(nodes, at, speed, velocity / np.where(speed > 0.0, speed, 1.0)[:, None], reversed_)


def _nodes(prepared: Prepared, state: State, rows: IntArray) -> tuple[QuadratureNodes, BoolArray]:
    """Nodes of the integrals, and whether the first point is at the upper end."""
    arcs, curves = prepared.network.arc_lengths, prepared.curves
    curve = prepared.network.curve_observations.curve[arcs.first[rows]]
    u1, u2 = state.location[arcs.first[rows]], state.location[arcs.second[rows]]
    low, high = np.minimum(u1, u2), np.maximum(u1, u2)
    reversed_ = u2 < u1
    ring = np.flatnonzero(curves.closed[curve])
    if len(ring):
        period = (curves.last - curves.first)[curve[ring]]
        way = np.mod(u2[ring] - u1[ring], period)
        low[ring], high[ring] = u1[ring], u1[ring] + way
        backward = way > 0.5 * period
        unclear = np.flatnonzero(np.minimum(way, period - way) > AMBIGUOUS * period)
        if len(unclear):
            some = ring[unclear]
            backward[unclear] = _is_backward(
                prepared, state, rows[some], low[some], high[some], period[unclear]
            )
        low[ring] = np.where(backward, u2[ring], low[ring])
        high[ring] = np.where(backward, u2[ring] + period - way, high[ring])
        reversed_[ring] = backward
    return quadrature_nodes(curves, curve, low, high, arcs.simpson[rows]), reversed_


def _is_backward(
    prepared: Prepared, state: State, rows: IntArray, low: FloatArray, high: FloatArray, period: FloatArray
) -> BoolArray:
    """Whether the way round from the second point to the first is nearer to the measured length."""
    curve = prepared.network.curve_observations.curve[prepared.network.arc_lengths.first[rows]]
    none = np.zeros(len(rows), dtype=bool)
    forward, back = (
        _evaluated(
            prepared, state, rows, quadrature_nodes(prepared.curves, curve, *ends, none), none
        ).lengths()
        for ends in ((low, high), (high, low + period))
    )
    measured = prepared.arc_lengths.value[rows]
    return np.asarray(np.abs(back - measured) < np.abs(forward - measured))
