"""Solutions of one network with changing weights."""

from __future__ import annotations

import numpy as np

from benchmarks.blunder_cases import clean_block
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.six_image_block import simulate_block
from splinebba_cli.simulation.truth import true_state


def network(sliding: float = 1.0) -> WeightedNetwork:
    prepared = prepare(clean_block(3).network)
    truth = true_state(prepared, simulate_block("six-image-mixed", 3, noise_um=0.0)[1])
    return WeightedNetwork(prepared, truth, None, None, "outliers", sliding)


def test_a_known_solution_is_judged_as_one_that_the_iterations_reach() -> None:
    """Iterations end at steps below 0.05 sigma: so far may standardised residuals differ."""
    weighted = network()
    factor = np.ones(len(weighted.listed))
    factor[-5:] = 0.0
    start = true_state(weighted.prepared, simulate_block("six-image-mixed", 3, noise_um=0.0)[1])
    solved = weighted.solve(factor, start)
    assert solved is not None
    known = weighted.known(factor, solved.state)
    assert known is not None and known.solved.solution.converged
    np.testing.assert_allclose(known.statistics.standardized, solved.statistics.standardized, atol=0.05)
    assert known.statistics.redundancy == solved.statistics.redundancy or np.isclose(
        known.statistics.redundancy, solved.statistics.redundancy, atol=1e-6
    )


def test_held_knots_slide_less() -> None:
    """The sigma of gauge conditions times 0.001: what is left of their residuals (m) is a thousandth at most, and more
    than that shrinks where the measurements pull."""
    moved = []
    for sliding in (1.0, 1e-3):
        weighted = network(sliding)
        start = true_state(weighted.prepared, simulate_block("six-image-mixed", 3, noise_um=0.0)[1])
        solved = weighted.solve(np.ones(len(weighted.listed)), start)
        assert solved is not None
        rows = solved.solved.assembler.coefficient_rows
        gauge = rows.component == 3
        moved.append(np.abs(rows.residual(solved.state.coefficients) * rows.sigma)[gauge].max())
    assert moved[1] < 0.01 * moved[0]
