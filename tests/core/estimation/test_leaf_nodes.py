"""Nodes that are eliminated first: which ones, and what they leave."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_cholesky import analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.leaf_batches import BATCH, inverse_triangles
from splinebba_cli.core.estimation.leaf_nodes import find_leaves, no_leaves, without_leaves
from tests.core.estimation.block_cases import random_values
from tests.core.estimation.test_ordering import _block


def _pattern(structure: BlockStructure) -> np.ndarray:
    pattern = np.zeros((structure.n_nodes, structure.n_nodes), dtype=bool)
    pattern[structure.rows, structure.cols] = True
    return pattern | pattern.T


def test_curves_of_a_block_are_leaves_and_couple_the_images_that_see_them() -> None:
    structure, _, n_images = _block(4, 8)
    leaves = find_leaves(structure, np.zeros(structure.n_nodes, dtype=bool))
    assert leaves.nodes.tolist() == list(range(n_images, structure.n_nodes))
    rest, nodes = without_leaves(structure, leaves)
    assert nodes.tolist() == list(range(n_images))
    seen = _pattern(structure)[:n_images, n_images:].astype(int)
    np.testing.assert_array_equal(_pattern(rest), (seen @ seen.T > 0) | np.eye(n_images, dtype=bool))


def test_no_two_leaves_are_coupled_and_none_is_global_or_has_many_neighbours() -> None:
    rng = np.random.default_rng(1)
    n = 80
    i, j = rng.integers(0, n, (2, 100))
    sizes = rng.integers(1, 40, n)
    structure = BlockStructure.from_pairs(sizes, i, j)
    everywhere = np.zeros(n, dtype=bool)
    everywhere[[3, 11]] = True
    leaves = find_leaves(structure, everywhere)
    pattern = _pattern(structure) & ~np.eye(n, dtype=bool)
    assert len(leaves.nodes) > 5
    assert not pattern[np.ix_(leaves.nodes, leaves.nodes)].any()
    assert not everywhere[leaves.nodes].any()
    for leaf, start, end in zip(leaves.nodes, leaves.start[:-1], leaves.start[1:], strict=True):
        neighbours = leaves.neighbours[start:end]
        assert sorted(neighbours) == np.flatnonzero(pattern[leaf]).tolist()
        assert sizes[neighbours[~everywhere[neighbours]]].sum() <= 90


def test_without_leaves_everything_stays() -> None:
    structure, _, _ = _block(2, 4)
    assert without_leaves(structure, no_leaves())[0] is structure


@pytest.mark.parametrize("count", [1, 7])
def test_triangles_are_inverted(count: int) -> None:
    lower = np.tril(np.random.default_rng(2).uniform(0.5, 1.0, (count, 15, 15))) + 3.0 * np.eye(15)
    product = np.matmul(inverse_triangles(lower), lower)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(15), product.shape), atol=1e-13)


def test_leaves_of_one_shape_come_in_batches() -> None:
    structure, positions, n_images = _block(12, 20)
    batches = analyse(structure, positions).batches
    assert sum(batch.end - batch.first for batch in batches) == structure.n_nodes - n_images
    assert max(batch.end - batch.first for batch in batches) <= BATCH


def test_dispersions_of_images_do_without_the_leaves(speed_mode: str) -> None:
    structure, positions, n_images = _block(4, 8)
    values = random_values(structure, np.random.default_rng(3))
    selected = analyse(structure, positions).factorize(values).selected_inverse()
    images = np.arange(n_images)
    before = selected.blocks(images, images)
    assert "panel" not in vars(selected)
    selected.blocks([n_images], [n_images])
    assert "panel" in vars(selected)
    np.testing.assert_array_equal(selected.blocks(images, images), before)
