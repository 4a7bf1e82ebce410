"""Block Cholesky factor against dense linear algebra; what it says when it fails."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_cholesky import NotPositiveDefinite, analyse
from splinebba_cli.core.estimation.block_matrix import BlockMatrix, BlockStructure, PairNotInPattern
from tests.core.estimation.block_cases import (
    TOLERANCE,
    Maker,
    build,
    every_case,
    geometric,
    random_values,
)

pytestmark = pytest.mark.usefixtures("speed_mode")


@every_case
def test_solution_and_determinant_equal_dense(maker: Maker) -> None:
    case = build(maker)
    dense = case.matrix.to_dense()
    symbolic = analyse(case.matrix.structure, case.positions)
    assert (len(symbolic.layout.pivots) > 1) == case.several_fronts
    factor = symbolic.factorize(case.matrix.values)
    rhs = np.random.default_rng(1).normal(size=(len(dense), 3))
    np.testing.assert_allclose(factor.solve(rhs), np.linalg.solve(dense, rhs), atol=TOLERANCE)
    np.testing.assert_allclose(factor.solve(rhs[:, 0]), factor.solve(rhs)[:, 0], atol=TOLERANCE)
    assert factor.log_determinant == pytest.approx(np.linalg.slogdet(dense)[1], rel=TOLERANCE)


def test_damping_is_added_to_the_diagonal() -> None:
    case = build(geometric)
    n = case.matrix.structure.n_unknowns
    damping = np.random.default_rng(2).uniform(0.0, 50.0, n)
    factor = analyse(case.matrix.structure, case.positions).factorize(case.matrix.values, damping)
    expected = np.linalg.solve(case.matrix.to_dense() + np.diag(damping), np.ones(n))
    np.testing.assert_allclose(factor.solve(np.ones(n)), expected, atol=TOLERANCE)


def test_symbolic_factor_serves_several_matrices_and_leaves_its_input_alone() -> None:
    case = build(geometric)
    symbolic = analyse(case.matrix.structure, case.positions)
    values = case.matrix.values.copy()
    rhs = np.ones(case.matrix.structure.n_unknowns)
    first = symbolic.factorize(values)
    x = first.solve(rhs)
    symbolic.factorize(2.0 * values).selected_inverse()
    np.testing.assert_array_equal(values, case.matrix.values)
    np.testing.assert_array_equal(rhs, 1.0)
    np.testing.assert_array_equal(first.solve(rhs), x)
    np.testing.assert_allclose(symbolic.factorize(2.0 * values).solve(rhs), x / 2.0, rtol=1e-12)


def test_renumbering_the_nodes_gives_the_same_solution() -> None:
    case = build(geometric)
    s = case.matrix.structure
    new = np.random.default_rng(3).permutation(s.n_nodes)
    old = np.argsort(new)
    renumbered = BlockStructure.from_pairs(s.sizes[old], new[s.rows], new[s.cols])
    values = np.empty(renumbered.n_entries)
    for b in range(len(s.rows)):
        i, j = new[s.rows[b]], new[s.cols[b]]
        block = case.matrix.blocks(np.array([b]))[0]
        to = renumbered.find([i], [j])[0]
        at = slice(renumbered.offsets[to], renumbered.offsets[to + 1])
        values[at] = (block if i <= j else block.T).ravel()
    rhs = np.random.default_rng(4).normal(size=s.n_unknowns)
    unknowns = np.concatenate([np.arange(s.starts[k], s.starts[k + 1]) for k in old])
    x = analyse(s, case.positions).factorize(case.matrix.values).solve(rhs)
    y = analyse(renumbered, case.positions[old]).factorize(values).solve(rhs[unknowns])
    np.testing.assert_allclose(y, x[unknowns], atol=TOLERANCE)


@pytest.mark.parametrize("node", [0, 17, 42, 89])
def test_a_negative_pivot_names_its_unknown(node: int) -> None:
    case = build(geometric)
    s = case.matrix.structure
    unknown = int(s.sizes[node]) - 1
    values = case.matrix.values.copy()
    block = s.find([node], [node])[0]
    values[s.offsets[block] + unknown * (s.sizes[node] + 1)] = -1e6
    with pytest.raises(NotPositiveDefinite) as raised:
        analyse(s, case.positions).factorize(values)
    assert (raised.value.node, raised.value.unknown_in_node) == (node, unknown)


def test_a_value_that_is_not_a_number_is_an_error() -> None:
    case = build(geometric)
    values = case.matrix.values.copy()
    values[case.matrix.structure.offsets[case.matrix.structure.find([11], [11])[0]]] = np.nan
    with pytest.raises(NotPositiveDefinite) as raised:
        analyse(case.matrix.structure, case.positions).factorize(values)
    assert (raised.value.node, raised.value.unknown_in_node) == (11, 0)


@pytest.mark.parametrize("node", [3, 30, 80])
def test_a_small_pivot_fails_relative_to_its_diagonal(node: int) -> None:
    """The last unknown of a node repeats the one before it but for 1e-9 of its weight."""
    case = build(geometric)
    s = case.matrix.structure
    sizes = s.sizes.copy()
    sizes[node] = 4
    structure = BlockStructure.from_pairs(sizes, s.rows, s.cols)
    dense = BlockMatrix(structure, random_values(structure, np.random.default_rng(6))).to_dense()
    last = structure.starts[node] + 3
    dense[last], dense[:, last] = dense[last - 1], dense[:, last - 1]
    dense[last, last] = dense[last, last - 1] = dense[last - 1, last] = dense[last - 1, last - 1]
    dense[last, last] *= 1.0 + 1e-9
    values = np.concatenate(
        [
            dense[starts_i:ends_i, starts_j:ends_j].ravel()
            for starts_i, ends_i, starts_j, ends_j in zip(
                structure.starts[structure.rows],
                structure.starts[structure.rows + 1],
                structure.starts[structure.cols],
                structure.starts[structure.cols + 1],
                strict=True,
            )
        ]
    )
    symbolic = analyse(structure, case.positions)
    symbolic.factorize(values)
    symbolic.factorize(values, pivot_tolerance=1e-11)
    symbolic.factorize(1e-12 * values, pivot_tolerance=1e-11)
    with pytest.raises(NotPositiveDefinite):
        symbolic.factorize(1e12 * values, pivot_tolerance=1e-7)
    with pytest.raises(NotPositiveDefinite) as raised:
        symbolic.factorize(values, pivot_tolerance=1e-7)
    assert (raised.value.node, raised.value.unknown_in_node) == (node, 3)
    assert raised.value.ratio == pytest.approx(1e-9, rel=1e-3)


@pytest.mark.parametrize("error", [NotPositiveDefinite(3, 2, 1e-9), PairNotInPattern(4, 5)])
def test_errors_survive_the_way_between_processes(error: Exception) -> None:
    copy = pickle.loads(pickle.dumps(error))
    assert str(copy) == str(error)
    assert vars(copy) == vars(error)


def test_a_symbolic_factor_survives_the_way_between_processes() -> None:
    case = build(geometric)
    symbolic = analyse(case.matrix.structure, case.positions)
    rhs = np.ones(case.matrix.structure.n_unknowns)
    x = symbolic.factorize(case.matrix.values).solve(rhs)
    copy = pickle.loads(pickle.dumps(symbolic))
    np.testing.assert_array_equal(copy.factorize(case.matrix.values).solve(rhs), x)


def test_wrong_lengths_are_errors() -> None:
    case = build(geometric)
    symbolic = analyse(case.matrix.structure, case.positions)
    with pytest.raises(ValueError, match="values expected"):
        symbolic.factorize(case.matrix.values[:-1])
    with pytest.raises(ValueError, match="damping"):
        symbolic.factorize(case.matrix.values, np.zeros(3))
    with pytest.raises(ValueError, match="rows expected"):
        symbolic.factorize(case.matrix.values).solve(np.zeros(3))
    with pytest.raises(ValueError, match="positions"):
        analyse(case.matrix.structure, case.positions[:-1])


def test_predictions_of_a_single_front_are_those_of_a_dense_matrix() -> None:
    n = 20
    structure = BlockStructure.from_pairs(np.full(n, 6), *np.triu_indices(n))
    symbolic = analyse(structure, np.random.default_rng(8).uniform(size=(n, 3)))
    assert symbolic.factor_entries == (6 * n) ** 2
    assert symbolic.flops == pytest.approx((6 * n) ** 3 / 3.0)


def test_thread_limits_are_restored_after_a_failure() -> None:
    threadpoolctl = pytest.importorskip("threadpoolctl")
    case = build(geometric)
    symbolic = analyse(case.matrix.structure, case.positions)
    with threadpoolctl.threadpool_limits(2, user_api="blas"):
        before = [pool["num_threads"] for pool in threadpoolctl.threadpool_info()]
        with pytest.raises(NotPositiveDefinite):
            symbolic.factorize(-case.matrix.values)
        assert [pool["num_threads"] for pool in threadpoolctl.threadpool_info()] == before


def test_an_empty_matrix_has_determinant_one() -> None:
    structure = BlockStructure.from_pairs([], [], [])
    factor = analyse(structure, np.zeros((0, 3))).factorize(np.zeros(0))
    assert factor.log_determinant == 0.0
    assert factor.solve(np.zeros(0)).shape == (0,)
    assert factor.selected_inverse().diagonal().shape == (0,)
