"""Iterations that only damped steps carry on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.damping import Damping
from splinebba_cli.core.estimation.gauss_markov import Solution, _Run, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.state import prepare
from tests.core.small_networks import mixed_network


@pytest.fixture(scope="module")
def solved() -> tuple[Assembler, Solution]:
    prepared = prepare(mixed_network()[0])
    layout = layout_of(prepared)
    mask = layout.coefficient_mask
    rows = concatenate_rows(
        [control_rows(prepared, mask), gauge_rows(prepared, mask, None)], prepared.curves.support
    )
    assembler = Assembler(prepared, layout, rows)
    return assembler, solve(assembler, starting_state(prepared)[0], max_iterations=50, stage="joint")


def ended(assembler: Assembler, shift_m: float, solution: Solution) -> Solution:
    """The end at a state whose perspective centres are off."""
    state = solution.state
    moved = search_locations(assembler.prepared, replace(state, position=state.position + shift_m))
    at = assembler.linearize(moved, held_locations(assembler.prepared, moved.location))
    run = _Run(assembler, "joint", None, Damping.starting(assembler, 1e-3), True)
    return run.ended_damped(at)


def test_a_small_undamped_step_makes_it_a_solution(solved: tuple[Assembler, Solution]) -> None:
    end = ended(solved[0], 0.0, solved[1])
    assert end.converged
    assert end.termination == "cost stationary"
    assert end.factor is not None


def test_a_large_one_does_not(solved: tuple[Assembler, Solution]) -> None:
    end = ended(solved[0], 0.5, solved[1])
    assert not end.converged
    assert end.termination == "no undamped step lowers the residuals"
    assert end.factor is None
