"""New curves that an adjustment settles with: iterated as it will be, other knots where they keep sliding.

Drafts hold their knots tightly along the curve, so that they stay where they are while points are linked; the
adjustment of the project holds them weakly.  Every curve is therefore iterated by itself as the adjustment does, with
the orientations held.  One that does not settle gets evenly spaced knots, a little farther apart or closer: those that
settle with the least v'Pv, the price of knots included, if it is not clearly more than before.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.knot_spacing import present_curve, respaced_network
from splinebba_cli.core.estimation.curve_stage import curves_alone
from splinebba_cli.core.estimation.gauss_markov import Solution, solve
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.matching.shapes.extent import straight_on
from splinebba_cli.core.matching.shapes.knot_need import PRICE
from splinebba_cli.core.network import Curve, Network, select_rows
from splinebba_cli.core.observations.coefficient_rows import knot_distance
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

ITERATIONS = 30  # of the fifty that an adjustment has
DAMPING = 1e-3
SPACINGS = (1.0, 0.8, 1.25, 0.6, 0.45)  # times the knot distance of a curve that does not settle
CLEARLY = 2.0 * PRICE  # of v'Pv


def settled_curves(draft: Draft) -> Draft:
    """The same links on curves that settle."""
    curves = tuple(_settled(draft, k, curve) for k, curve in enumerate(draft.present_curves()))
    return with_curves(draft, curves)


def _settled(draft: Draft, k: int, curve: Curve) -> Curve:
    """One curve, iterated; as it was where nothing helps."""
    prepared, state = _alone(draft, k, curve)
    first = _solved(prepared, state)
    if first is None:
        return curve
    if first.converged:
        return _curve_of(first)
    most = _price(first) + CLEARLY
    for factor in SPACINGS:
        spacing = np.array([factor * knot_distance(curve)])
        other = _solved(*respaced_network(prepared, first.state, spacing, smooth=False))
        if other is not None and other.converged and _price(other) < most:
            most, curve = _price(other), _curve_of(other)
    return curve


def _solved(prepared: Prepared, state: State) -> Solution | None:
    """The curve iterated until no step is left that counts; None where it comes behind a camera."""
    try:
        return solve(
            curves_alone(prepared), state,
            max_iterations=ITERATIONS, stage="new curves", damping=DAMPING, stationary=0.0,
        )  # fmt: skip
    except FloatingPointError:
        return None


def _price(solution: Solution) -> float:
    """v'Pv and the price of the knots."""
    return solution.linearization.cost + PRICE * len(solution.state.coefficients)


def _curve_of(solution: Solution) -> Curve:
    """The iterated curve, its ends at the outermost links: they slide along it as all knots do."""
    prepared, state = solution.linearization.prepared, solution.state
    curve, basis = present_curve(prepared, 0, state.coefficients), prepared.curves.bases[0]
    if curve.closed:
        return curve
    parameters, values = basis.break_points.copy(), curve.values.copy()
    parameters[0] = min(parameters[0], float(state.location.min()))
    parameters[-1] = max(parameters[-1], float(state.location.max()))
    values[[0, -1]] = straight_on(basis, state.coefficients, parameters[[0, -1]])
    return replace(curve, values=values, knot_parameters=parameters)


def _alone(draft: Draft, k: int, curve: Curve) -> tuple[Prepared, State]:
    """A network of one curve whose values are free, and its links."""
    own = draft.links_by_curve[k]
    links = replace(select_rows(draft.links, own), curve=np.zeros(len(own), dtype=np.int64))
    network: Network = replace(draft.prepared.network, curves=(curve,), curve_observations=links)
    prepared = prepare(network)
    return prepared, replace(
        draft.state, coefficients=initial_coefficients(prepared), location=draft.state.location[own]
    )
