"""Memory of the normal equations: predicted before it is taken, and refused where it is not there."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from splinebba_cli.core.estimation import factor_memory as module
from splinebba_cli.core.estimation.block_cholesky import analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.factor_memory import NUMBER, VALUE_ARRAYS, factor_memory, require_memory
from splinebba_cli.errors import ExitCode, NotEnoughMemoryError
from tests.core.estimation.block_cases import random_values
from tests.core.estimation.test_ordering import _block


def test_a_single_front_is_a_dense_matrix(speed_mode: str) -> None:
    n = 20
    structure = BlockStructure.from_pairs(np.full(n, 6), *np.triu_indices(n))
    memory = factor_memory(analyse(structure))
    assert memory.factor == memory.inverse == NUMBER * (6 * n) ** 2
    assert memory.assembly == NUMBER * VALUE_ARRAYS * structure.n_entries
    assert memory.update == 0


def test_prediction_against_what_numpy_takes(speed_mode: str) -> None:
    """Within a quarter, both ways: half of what is predicted or twice as much would be no prediction."""
    structure, positions, _ = _block(12, 20)
    values = random_values(structure, np.random.default_rng(1))
    analyse(structure, positions).factorize(values).selected_inverse()  # what is loaded once
    tracemalloc.start()
    symbolic = analyse(structure, positions)
    factor = symbolic.factorize(values)
    factor.solve(np.ones(structure.n_unknowns))
    assert factor.selected_inverse().panel.size == symbolic.factor_entries
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    predicted = factor_memory(symbolic)
    assert predicted.peak - predicted.assembly == pytest.approx(taken, rel=0.25)


def test_a_limit_that_is_too_small_says_what_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    symbolic = analyse(*_block(12, 20)[:2])
    needed = factor_memory(symbolic).peak
    monkeypatch.setattr(module, "available_memory", lambda: needed)
    assert require_memory(symbolic).peak == needed
    monkeypatch.setattr(module, "available_memory", lambda: needed - 1)
    with pytest.raises(NotEnoughMemoryError) as raised:
        require_memory(symbolic)
    assert raised.value.exit_code == ExitCode.NOT_SOLVABLE
    (problem,) = raised.value.problems
    assert (raised.value.code, problem.code) == ("SBB570", "SBB570")
    assert f"{symbolic.structure.n_unknowns} unknowns need {needed / 2**20:.1f} MiB" in problem.message
    assert "ulimit" in problem.help
    assert "parts" in problem.help


def test_features_seen_everywhere_get_other_help() -> None:
    """A dense system is one front: parts would not help, shorter splines do."""
    n = 60
    structure = BlockStructure.from_pairs(np.full(n, 6), *np.triu_indices(n))
    with pytest.raises(NotEnoughMemoryError) as raised:
        require_memory(analyse(structure), 1.0)
    assert "shorter" in raised.value.problems[0].help
