"""C'S^-1 C of sparse columns by forward substitution, against the dense inverse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from splinebba_cli.core.estimation import half_solution
from splinebba_cli.core.estimation.block_cholesky import Factor, analyse
from splinebba_cli.core.estimation.half_solution import gram, gram_band
from tests.core.estimation.block_cases import TOLERANCE, Case, Maker, build, curves_and_images, every_case


def factor_of(case: Case) -> Factor:
    return analyse(case.matrix.structure, case.positions).factorize(case.matrix.values)


def columns_of(case: Case, count: int) -> sparse.csc_array:
    """Columns of a few entries each, one of them empty, the last one dense."""
    generator = np.random.default_rng(3)
    size = case.matrix.structure.n_unknowns
    dense = np.zeros((size, count))
    for k in range(1, count):
        rows = generator.choice(size, 3, replace=False)
        dense[rows, k] = generator.standard_normal(3)
    dense[:, -1] = generator.standard_normal(size)
    return sparse.csc_array(dense)


@every_case
def test_all_products(maker: Maker) -> None:
    case = build(maker)
    columns = columns_of(case, 7)
    expected = columns.toarray().T @ np.linalg.solve(case.matrix.to_dense(), columns.toarray())
    found = gram(factor_of(case), columns)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=TOLERANCE * np.abs(expected).max())


@pytest.mark.parametrize("alone", [0, 10**9])
def test_leaves_in_batches_or_alone(alone: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether a batch of leaves is worked on as one does not change the products."""
    case = build(curves_and_images)
    columns, factor = columns_of(case, 7), factor_of(case)
    assert factor.symbolic.batches
    monkeypatch.setattr(half_solution, "ALONE", alone)
    expected = columns.toarray().T @ np.linalg.solve(case.matrix.to_dense(), columns.toarray())
    found = gram(factor, columns)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=TOLERANCE * np.abs(expected).max())


@every_case
def test_products_inside_blocks_only(maker: Maker) -> None:
    case = build(maker)
    columns, block = columns_of(case, 8), np.array([0, 1, 1, 1, 2, 2, 3, 3])
    expected = columns.toarray().T @ np.linalg.solve(case.matrix.to_dense(), columns.toarray())
    found = gram_band(factor_of(case), columns, block)
    assert found.shape == (3, 8)
    for i in range(8):
        for d in range(3):
            inside = i + d < 8 and block[i] == block[i + d]
            value = expected[i, i + d] if inside else 0.0
            assert abs(found[d, i] - value) <= TOLERANCE * np.abs(expected).max()


def test_a_column_reaches_its_front_and_those_above() -> None:
    factor = factor_of(build(curves_and_images))
    parents = factor.symbolic.layout.tree.parent
    assert len(parents) > 3
    place = np.zeros(1, dtype=np.int64)  # the first unknown that is eliminated
    found = half_solution._reach(factor, place, np.zeros(1, dtype=np.int64), 1)[:, 0]
    path, front = [], 0
    while front >= 0:
        path.append(front)
        front = int(parents[front])
    assert np.flatnonzero(found).tolist() == path
    assert found.sum() < len(parents)
