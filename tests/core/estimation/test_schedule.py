"""Parts of the assembly tree: independent of each other, and nothing that still waits is overwritten."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core import speed, threads
from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor, analyse
from splinebba_cli.core.estimation.compiled_fronts import CompiledFronts
from splinebba_cli.core.estimation.schedule import Schedule, schedule
from tests.core.estimation.block_cases import build, curves_and_images, random_values
from tests.core.estimation.test_ordering import _block


def _scheduled(n_parts: int) -> tuple[SymbolicFactor, Schedule]:
    structure, positions, _ = _block(8, 16)
    symbolic = analyse(structure, positions)
    return symbolic, schedule(symbolic.layout, n_parts)


@pytest.mark.parametrize("n_parts", [1, 2, 3])
def test_parts_hold_every_front_once_and_only_the_top_lies_above_them(n_parts: int) -> None:
    symbolic, order = _scheduled(n_parts)
    assert sorted(np.concatenate([*order.parts, order.top]).tolist()) == list(symbolic.fronts)
    parent, top = symbolic.layout.tree.parent, set(order.top.tolist())
    for part in order.parts:
        inside = set(part.tolist())
        assert len(part) > 0
        assert all(parent[f] in inside or parent[f] in top or parent[f] < 0 for f in inside)
    assert all(parent[f] in top or parent[f] < 0 for f in top)


@pytest.mark.parametrize("n_parts", [1, 3])
def test_updates_that_wait_are_not_overwritten(n_parts: int) -> None:
    symbolic, order = _scheduled(n_parts)
    parent, squares = symbolic.layout.tree.parent, symbolic.layout.rows**2
    owner = np.full(order.update_size, -1)
    for front in np.concatenate([*order.parts, order.top]).tolist():
        own = slice(order.update[front], order.update[front] + squares[front])
        assert np.all(owner[own] < 0)
        owner[own] = front
        for child in order.children[order.child_start[front] : order.child_start[front + 1]].tolist():
            if child >= symbolic.layout.tree.n_leaves:
                of_child = slice(order.update[child], order.update[child] + squares[child])
                assert np.all(owner[of_child] == child)
                owner[of_child] = -1
    assert np.all(parent[owner[owner >= 0]] < 0)


@pytest.mark.parametrize("n_parts", [1, 3])
def test_outer_inverses_stay_until_the_fronts_below_have_taken_theirs(n_parts: int) -> None:
    symbolic, order = _scheduled(n_parts)
    parent, squares = symbolic.layout.tree.parent, symbolic.layout.rows**2
    owner = np.full(order.outer_size, -1)
    for front in [*order.top[::-1], *(f for part in order.parts for f in part[::-1])]:
        above = parent[front]
        if above >= 0:
            assert np.all(owner[order.outer[above] : order.outer[above] + squares[above]] == above)
        owner[order.outer[front] : order.outer[front] + squares[front]] = front


@pytest.mark.parametrize("count", ["1", "2", "3"])
def test_kernels_give_the_results_of_plain_numpy(monkeypatch: pytest.MonkeyPatch, count: str) -> None:
    """The same operations in another order: 1e-12 of the largest leaves four digits for rounding."""
    pytest.importorskip("numba")
    monkeypatch.setenv(threads.VARIABLE, count)
    structure, positions, _ = _block(6, 12)
    values = random_values(structure, np.random.default_rng(5))
    rhs = np.random.default_rng(6).normal(size=(structure.n_unknowns, 2))
    symbolic = analyse(structure, positions)
    assert len(CompiledFronts.of(symbolic.layout, symbolic.places).schedule.parts) == int(count)
    results = []
    for mode in ("never", "always"):
        monkeypatch.setenv(speed.VARIABLE, mode)
        factor = symbolic.factorize(values)
        results.append((factor.panel[symbolic.layout.diagonal_entries], factor.solve(rhs)))
        results[-1] += (factor.selected_inverse().values,)
    for plain, compiled in zip(*results, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=0.0, atol=1e-12 * np.abs(plain).max())


def test_curves_alone_are_leaves_without_rows(speed_mode: str) -> None:
    """With all orientations held the curves are coupled with nothing."""
    case = build(curves_and_images)
    s = case.matrix.structure
    alone = type(s).from_pairs(np.full(40, 15), [], [])
    values = random_values(alone, np.random.default_rng(7))
    symbolic = analyse(alone, None)
    factor = symbolic.factorize(values)
    blocks = values.reshape(40, 15, 15)
    assert len(symbolic.fronts) == 0
    expected = np.linalg.solve(blocks, np.ones((40, 15, 1)))
    np.testing.assert_allclose(factor.solve(np.ones(600)), expected.ravel(), atol=1e-12)
    inverse = factor.selected_inverse().values.reshape(40, 15, 15)
    np.testing.assert_allclose(inverse, np.linalg.inv(blocks), atol=1e-12)
