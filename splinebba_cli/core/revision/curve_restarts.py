"""Curves started anew with orientations and points held; every curve keeps the shape of the lowest cost.

    cost of a curve   sum r^2 / (1 + (r / s)^2) + conditions,   s the last scale (Geman and McClure 1987)

Among many errors a curve easily ends in a false minimum: a stretch leaves a dozen good points for two or three wrong
ones.  With orientations that are nearly right curves no longer depend on each other, so that each can be tried from its
approximate shape with scales that begin narrower and shrink more slowly than those of the whole network, at little
cost; a lower cost is the better answer to the same question.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.curve_stage import curves_alone, merged, solve_curves
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.revision.graduated_weights import costs, last_scale, residual_size, weights
from splinebba_cli.core.revision.observation_list import CURVES, DISTANCES, ObservationList
from splinebba_cli.core.revision.observation_weights import faintly_weighted
from splinebba_cli.core.state import Prepared, State

WIDTHS = (10.0, 30.0, 100.0)  # first scales, times the last one
SHRINKING = 0.8  # a step
ITERATIONS = 2  # of the curves a step
GAIN = 1.0  # of the cost that makes another shape the better one


def restarted(
    prepared: Prepared,
    listed: ObservationList,
    approximate: State,
    state: State,
    excluded: FloatArray,
    sliding: float,
) -> tuple[FloatArray, State]:
    """Weights (N,) and state with the best shape of every curve.

    Parameters
    ----------
    prepared : all measurements with their given sigma
    approximate : shapes from which curves are started anew
    state : orientations, points, and the shapes to be bettered
    excluded : (N,) 0 for what stays out, else 1
    sliding : factor of the sigma of gauge conditions
    """
    curves = _Curves.of(curves_alone(prepared, sliding), listed, excluded, state)
    best, lowest = curves.narrowed(state, 1.0)
    for width in WIDTHS:
        begin = replace(state, coefficients=approximate.coefficients, location=approximate.location)
        try:
            other, cost = curves.narrowed(begin, width)
        except FloatingPointError:  # a shape that reaches behind a camera is none
            continue
        better = cost < lowest - GAIN
        best, lowest = merged(prepared, best, other, better), np.where(better, cost, lowest)
    return curves.weights(_equations(curves.assembler, best), curves.last), best


@dataclass(frozen=True)
class _Curves:
    assembler: Assembler  # of curves alone, with the given weights
    listed: ObservationList
    excluded: FloatArray  # (N,)
    last: float  # scale

    @classmethod
    def of(cls, assembler: Assembler, listed: ObservationList, excluded: FloatArray, state: State) -> _Curves:
        """With the last scale that the residuals of a state ask for."""
        at = _equations(assembler, search_locations(assembler.prepared, state))
        return cls(assembler, listed, excluded, last_scale(residual_size(listed, at), excluded))

    def narrowed(self, state: State, width: float) -> tuple[State, FloatArray]:
        """Shapes when the scale has come down from `width` times the last one, and the cost of each curve, (nc,)."""
        prepared = self.assembler.prepared
        at = _equations(self.assembler, search_locations(prepared, state))
        while True:
            factor = self.weights(at, width * self.last)
            weighted = self.assembler.with_weights(faintly_weighted(prepared, self.listed, factor))
            at = _equations(self.assembler, solve_curves(weighted, at.state, max_iterations=ITERATIONS))
            if width <= 1.0:
                return at.state, self._cost(at)
            width = max(1.0, SHRINKING * width)

    def weights(self, at: Linearization, scale: float) -> FloatArray:
        """Weights of all measurements, (N,)."""
        return weights(residual_size(self.listed, at), scale, self.excluded)

    def _cost(self, at: Linearization) -> FloatArray:
        r = residual_size(self.listed, at)
        linked = slice(int(self.listed.starts[CURVES]), int(self.listed.starts[DISTANCES]))
        rho = costs(r, self.last, self.excluded)[linked]
        network = self.assembler.prepared.network
        curve = self.listed.feature[linked] - len(network.points.ids)
        cost = np.bincount(curve, rho, minlength=len(network.curves))
        rows = self.assembler.coefficient_rows.curve
        return np.asarray(cost + np.bincount(rows, at.coefficient_residual**2, minlength=len(network.curves)))


def _equations(assembler: Assembler, state: State) -> Linearization:
    return assembler.linearize(state, held_locations(assembler.prepared, state.location))
