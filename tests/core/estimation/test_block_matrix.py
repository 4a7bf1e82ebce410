"""Block structures and matrices against dense ones."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from tests.core.estimation.block_cases import Maker, build, every_case


def test_structure_merges_duplicates_and_orientations() -> None:
    structure = BlockStructure.from_pairs([2, 3, 1], [2, 0, 0], [0, 2, 0])
    assert structure.rows.tolist() == [0, 0, 1, 2]
    assert structure.cols.tolist() == [0, 2, 1, 2]
    assert structure.offsets.tolist() == [0, 4, 6, 15, 16]
    assert structure.starts.tolist() == [0, 2, 5, 6]
    assert structure.find([2, 1], [0, 1]).tolist() == [1, 2]
    for sizes, pairs in (([1, 0], [0]), ([1, 1], [2]), ([1, 1], [-1])):
        with pytest.raises(ValueError, match="node"):
            BlockStructure.from_pairs(sizes, pairs, [0])


@every_case
def test_matrix_products_and_diagonal_equal_dense(maker: Maker) -> None:
    case = build(maker)
    dense = case.matrix.to_dense()
    np.testing.assert_array_equal(dense, dense.T)
    np.testing.assert_array_equal(case.matrix.diagonal(), np.diag(dense))
    x = np.random.default_rng(9).normal(size=len(dense))
    np.testing.assert_allclose(case.matrix.multiply(x), dense @ x, atol=1e-13 * np.abs(dense).sum(1).max())
