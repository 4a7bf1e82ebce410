"""Steps with a factor that is kept: near the solution the matrix hardly changes, and the right-hand side is cheap.

    N_0 d = h(x),   x <- x + d        (the simplified Newton method)

A share rho of each step is left for the next one; after a step of length L the rest is about L rho / (1 - rho).  Only
networks of curves of powers, given coefficients and priors; the rest has its full steps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import Factor
from splinebba_cli.core.estimation.located_points import Located, ResidualsOnCurves
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import SHAPE
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.observations.orientation_priors import linearize_orientation_priors
from splinebba_cli.core.state import State

LONGEST = 2.0  # sigma: the step after which the factor is kept
CONTRACTING = 0.3  # of the last step, at most
MOST = 4  # steps with one factor


@dataclass(frozen=True)
class SimplifiedStep:
    """One step."""

    cost: float  # before it
    length: float  # sqrt(d'h), sigma
    reduced: FloatArray  # (N,) d


def applicable(assembler: Assembler) -> bool:
    """Whether the network has nothing but curves of powers, given coefficients and priors."""
    network, curves = assembler.prepared.network, assembler.prepared.curves
    return not (
        len(network.points.ids)
        or len(network.distances)
        or len(assembler.prepared.chains)
        or curves.any_trigonometric
        or (assembler.coefficient_rows.component == SHAPE).any()
    )


def simplified_step(assembler: Assembler, factor: Factor, state: State) -> SimplifiedStep | None:
    """The step from a state whose locations are foot points; None where there is none.

    There is none where something lies behind a camera, or a location has left its block (the pattern would change).
    """
    prepared, rows = assembler.prepared, assembler.coefficient_rows
    side = np.zeros(int(assembler.layout.node_starts[-1]))
    held = np.zeros(len(prepared.network.curve_observations), dtype=bool)
    held[held_locations(prepared, state.location)] = True
    on_curves = ResidualsOnCurves.none(len(held))
    try:
        assembler.add_curve_side(Located.of(prepared, state), held, side, on_curves)
    except FloatingPointError:
        return None
    coefficient = rows.residual(state.coefficients)
    assembler.coefficients.add_right_side(rows.jacobian_at(state.coefficients), coefficient, side)
    priors = linearize_orientation_priors(prepared.network.images, state)
    image_side = side[: assembler.layout.image_mask.size].reshape(-1, 6)
    image_side[priors.image] -= np.einsum("qij,qi->qj", priors.jacobian, priors.residual)
    side *= assembler.mask
    cost = float(on_curves.squares.sum() + coefficient @ coefficient) + priors.cost
    reduced = factor.solve(side) * assembler.mask
    return SimplifiedStep(cost, float(np.sqrt(max(float(side @ reduced), 0.0))), reduced)


def lengths_left(length: float, last: float) -> float:
    """What is left after a step of this length, the one before having been `last`."""
    rate = length / last
    return length * rate / (1.0 - rate)
