"""Steps with a factor that is kept."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core import speed
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation import gauss_markov
from splinebba_cli.core.estimation.gauss_markov import Solution, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.estimation.simplified_steps import applicable, lengths_left, simplified_step
from splinebba_cli.core.network import Network
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.observations.random_network import random_case
from tests.core.small_networks import mixed_network


@cache
def network() -> Network:
    """Six images with priors and splines alone, every knot weighted, so that iterations contract slowly."""
    block, truth = simulate_block("six-image", 3, 5.0)
    sigma = np.tile([1e-4, 1e-4, 1e-4, 0.1, 0.1, 0.1], (len(block.images.ids), 1))
    images = replace(block.images, prior=truth.eop.copy(), prior_sigma=sigma)
    block = replace(block, images=images)
    curves = tuple(
        curve if (curve.sigma == 0.0).all() else replace(curve, sigma=np.full(curve.sigma.shape, 2.0))
        for curve in block.curves
    )
    return replace(block, curves=curves)


def assembler_of(block: Network) -> tuple[Assembler, State]:
    prepared = prepare(block)
    layout = layout_of(prepared)
    rows = [
        control_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, None),
    ]
    assembler = Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))
    return assembler, starting_state(prepared)[0]


def solved() -> tuple[Assembler, Solution]:
    assembler, state = assembler_of(network())
    return assembler, solve(assembler, state, max_iterations=40, stage="joint")


@pytest.mark.parametrize("mode", ["never", "always"])
def test_the_right_side_is_that_of_the_normal_equations(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if mode == "always":
        pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, mode)
    assembler, state = assembler_of(network())
    state = search_locations(assembler.prepared, state)
    at = assembler.linearize(state, held_locations(assembler.prepared, state.location))
    values, side, _ = assembler.eliminate(at, 0.0)
    factor = assembler.symbolic(state).factorize(values)
    step = simplified_step(assembler, factor, state)
    assert step is not None
    full = factor.solve(side) * assembler.mask
    np.testing.assert_allclose(step.reduced, full, rtol=0.0, atol=1e-9 * np.abs(full).max())
    assert step.cost == pytest.approx(at.cost, rel=1e-12)
    assert step.length == pytest.approx(np.sqrt(side @ full), rel=1e-9)


def test_the_same_solution_with_and_without() -> None:
    """Both end where the worst function is good to 0.002 sigma; they differ by no more than that."""
    assembler, kept = solved()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gauss_markov, "LONGEST", 0.0)
        _, full = solved()
    assert kept.converged and full.converged
    assert len(kept.iterations) >= len(full.iterations)
    inverse = full.factor.selected_inverse().diagonal() if full.factor else np.zeros(0)
    sigma = np.sqrt(inverse[: 6 * assembler.layout.image_count]).reshape(-1, 6)
    difference = np.abs(kept.state.position - full.state.position) / sigma[:, 3:]
    assert difference.max() < 2 * gauss_markov.NEGLIGIBLE
    assert kept.linearization.cost == pytest.approx(full.linearization.cost, rel=1e-6)


def test_what_is_left() -> None:
    """1 + 1/4 + 1/16 + ... after 4: of the step 1, 1/3 is left."""
    assert lengths_left(1.0, 4.0) == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize(
    ("block", "possible"),
    [(network, True), (lambda: mixed_network()[0], False), (lambda: random_case().prepared.network, False)],
    ids=["splines", "points and distances", "every family"],
)
def test_only_for_curves_of_powers(block: object, possible: bool) -> None:
    assert callable(block)
    assembler, _ = assembler_of(block())
    assert applicable(assembler) is possible


def test_behind_a_camera() -> None:
    assembler, solution = solved()
    assert solution.factor is not None
    position = solution.state.position.copy()
    position[0, 2] = -1000.0
    prepared: Prepared = assembler.prepared
    assert prepared is not None
    assert simplified_step(assembler, solution.factor, replace(solution.state, position=position)) is None


def test_from_the_solution_no_step_is_taken() -> None:
    """The first step is below the bound: adjusting again changes nothing, not even last digits."""
    assembler, solution = solved()
    again = solve(assembler, solution.state, max_iterations=10, stage="joint")
    assert again.converged
    assert len(again.iterations) == 1
    assert np.array_equal(again.state.position, solution.state.position)
    assert np.array_equal(again.state.coefficients, solution.state.coefficients)
