"""New curves that an adjustment settles with: iterated as it will be, other knots where they keep sliding.

Drafts hold their knots tightly along the curve, so that they stay where they are while points are linked; the
adjustment of the project holds them weakly.  Every curve is therefore iterated by itself as the adjustment does, with the
orientations held; one that does not settle gets knots a little farther apart or closer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.curve_refinement import calmed
from splinebba_cli.core.approximation.knot_spacing import present_curve
from splinebba_cli.core.estimation.curve_stage import curves_alone
from splinebba_cli.core.estimation.gauss_markov import Solution, solve
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.network import Curve, Network, select_rows
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare

ITERATIONS = 30  # of the fifty that an adjustment has
ROUNDS = 4
DAMPING = 1e-3


def settled_curves(draft: Draft) -> Draft:
    """The same links on curves that settle."""
    curves = tuple(_settled(draft, k) for k in range(len(draft.curves)))
    return with_curves(draft, curves)


def _settled(draft: Draft, k: int) -> Curve:
    """One curve, iterated; as it was where nothing helps."""
    prepared, state = _alone(draft, k)
    for number in range(ROUNDS):
        try:
            solution = _solved(prepared, state)
        except FloatingPointError:  # behind a camera
            break
        if solution.converged:
            return present_curve(prepared, 0, solution.state.coefficients)
        if number < ROUNDS - 1:
            prepared, state = calmed(prepared, solution.state, (0,), None)
    return draft.present_curves()[k]


def _solved(prepared: Prepared, state: State) -> Solution:
    return solve(
        curves_alone(prepared), state, max_iterations=ITERATIONS, stage="new curves", damping=DAMPING, stationary=0.0
    )  # fmt: skip


def _alone(draft: Draft, k: int) -> tuple[Prepared, State]:
    """A network of one curve whose values are free, and its links."""
    own = np.flatnonzero(draft.links.curve == k)
    links = select_rows(draft.links, own)
    network: Network = replace(
        draft.prepared.network,
        curves=(draft.present_curves()[k],),
        curve_observations=replace(links, curve=np.zeros(len(own), dtype=np.int64)),
    )
    prepared = prepare(network)
    return prepared, replace(
        draft.state, coefficients=initial_coefficients(prepared), location=draft.state.location[own]
    )
