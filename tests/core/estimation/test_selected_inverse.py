"""Selected inverse against the dense inverse, on the pattern and on the fill."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor, analyse
from splinebba_cli.core.estimation.block_matrix import BlockMatrix, BlockStructure, PairNotInPattern
from tests.core.estimation.block_cases import (
    TOLERANCE,
    Maker,
    build,
    chain,
    curves_and_images,
    every_case,
    random_values,
)

pytestmark = pytest.mark.usefixtures("speed_mode")


@every_case
def test_selected_inverse_equals_dense_on_the_pattern(maker: Maker) -> None:
    case = build(maker)
    structure = case.matrix.structure
    symbolic = analyse(structure, case.positions)
    selected = symbolic.factorize(case.matrix.values).selected_inverse()
    inverse = np.linalg.inv(case.matrix.to_dense())
    scale = np.abs(inverse).max()
    on_pattern = BlockMatrix(structure, selected.values).to_dense()
    pattern = BlockMatrix(structure, np.ones(structure.n_entries)).to_dense() == 1.0
    np.testing.assert_allclose(on_pattern, np.where(pattern, inverse, 0.0), atol=TOLERANCE * scale)
    np.testing.assert_allclose(selected.diagonal(), np.diag(inverse), atol=TOLERANCE * scale)


@every_case
def test_blocks_of_the_inverse_in_both_orientations_and_outside_the_structure(maker: Maker) -> None:
    case = build(maker)
    structure = case.matrix.structure
    symbolic = analyse(structure, case.positions)
    selected = symbolic.factorize(case.matrix.values).selected_inverse()
    inverse = np.linalg.inv(case.matrix.to_dense())
    pairs = _factor_pairs(symbolic)
    assert {tuple(p) for p in np.c_[structure.rows, structure.cols].tolist()} <= pairs
    starts = structure.starts
    for turned in (False, True):
        chosen = np.array(sorted(pairs))[:, :: -1 if turned else 1]
        for (i, j), block in zip(chosen, selected.blocks(*chosen.T), strict=True):
            expected = inverse[starts[i] : starts[i + 1], starts[j] : starts[j + 1]]
            np.testing.assert_allclose(block, expected, atol=TOLERANCE * np.abs(inverse).max())


def _factor_pairs(symbolic: SymbolicFactor) -> set[tuple[int, int]]:
    """All pairs of nodes, low ≤ high, that a front holds."""
    tree = symbolic.layout.tree
    pairs = set()
    for front in range(len(tree.parent)):
        pivots = tree.order[tree.first[front] : tree.first[front + 1]].tolist()
        members = pivots + tree.order[tree.rows(front)].tolist()
        pairs |= {(min(p, q), max(p, q)) for p in pivots for q in members}
    return pairs


def test_window_gathers_the_covariance_of_groups() -> None:
    rng = np.random.default_rng(20080101)
    sizes, rows, cols, positions, _ = curves_and_images(rng)
    s = BlockStructure.from_pairs(sizes, rows, cols)
    matrix = BlockMatrix(s, random_values(s, rng))
    selected = analyse(s, positions).factorize(matrix.values).selected_inverse()
    inverse = np.linalg.inv(matrix.to_dense())
    short = (s.sizes[s.rows] == 6) & (s.sizes[s.cols] == 15)
    groups = np.c_[s.rows[short], s.cols[short]][:, ::-1]
    window = selected.window(groups)
    assert window.shape == (len(groups), 21, 21)
    for group, found in zip(groups, window, strict=True):
        unknowns = np.concatenate([np.arange(s.starts[k], s.starts[k + 1]) for k in group])
        expected = inverse[np.ix_(unknowns, unknowns)]
        np.testing.assert_allclose(found, expected, atol=TOLERANCE * np.abs(inverse).max())
    with pytest.raises(ValueError, match="equal sizes"):
        selected.window([[0, 1], [0, 48]])
    assert selected.window(np.zeros((0, 2), dtype=int)).shape[0] == 0


def test_pairs_outside_the_pattern_are_named() -> None:
    rng = np.random.default_rng(7)
    sizes, rows, cols, positions, _ = chain(rng)
    structure = BlockStructure.from_pairs(sizes, rows, cols)
    selected = analyse(structure, positions).factorize(random_values(structure, rng)).selected_inverse()
    with pytest.raises(PairNotInPattern, match=r"\(2, 60\)"):
        selected.blocks([0, 2], [1, 60])
    with pytest.raises(KeyError, match=r"\(5, 3\)"):
        structure.find([4, 5], [3, 3])
    with pytest.raises(KeyError):
        structure.find([0], [len(sizes)])
