"""Nested dissection: separators separate, are light, and follow the graph if positions mislead."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_cholesky import analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.fronts import build_fronts
from splinebba_cli.core.estimation.ordering import ROOT, nested_dissection
from splinebba_cli.core.estimation.vertex_separator import (
    FIRST,
    SECOND,
    SEPARATOR,
    vertex_separators,
)


def _grid(columns: int, rows: int, size: int = 6) -> tuple[BlockStructure, np.ndarray]:
    """Nodes in a grid, each coupled with its eight neighbours."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows)))
    number = np.arange(columns * rows)
    pairs = []
    for dx, dy in ((1, 0), (0, 1), (1, 1), (-1, 1)):
        inside = (x + dx >= 0) & (x + dx < columns) & (y + dy < rows)
        pairs.append(np.c_[number, number + dy * columns + dx][inside])
    structure = BlockStructure.from_pairs(np.full(len(number), size), *np.concatenate(pairs).T)
    return structure, np.c_[x, y].astype(float)


def _block(n_strips: int = 12, n_images: int = 20) -> tuple[BlockStructure, np.ndarray, int]:
    """Aerial block: images 1 x 2 apart that see 5 x 3 grid cells, three short curves per image."""
    rng = np.random.default_rng(1)
    strip, place = np.divmod(np.arange(n_strips * n_images), n_images)
    image = np.c_[place, 2.0 * strip, np.full(len(place), 4.0)]
    extent = [n_images - 1.0, 2.0 * (n_strips - 1), 0.0]
    curve = rng.uniform([0.0, 0.0, 0.0], extent, (3 * len(image), 3))
    offset = np.abs(curve[:, None, :2] - image[None, :, :2])
    c, i = np.nonzero((offset[..., 0] < 1.2) & (offset[..., 1] < 1.4))
    sizes = np.r_[np.full(len(image), 6), np.full(len(curve), 15)]
    structure = BlockStructure.from_pairs(sizes, i, len(image) + c)
    return structure, np.r_[image, curve], len(image)


def _ancestors(parent: np.ndarray, part: int) -> set[int]:
    line = set()
    while part >= 0:
        line.add(part)
        part = int(parent[part])
    return line


def test_coupled_nodes_lie_on_one_line_to_the_root() -> None:
    structure, positions, _ = _block()
    dissection = nested_dissection(structure, positions, 60)
    lines = [_ancestors(dissection.parent, p) for p in range(len(dissection.parent))]
    assert max(map(len, lines)) > 5
    for i, j in zip(dissection.part[structure.rows], dissection.part[structure.cols], strict=True):
        assert i in lines[j] or j in lines[i]


def test_parts_at_the_end_are_small() -> None:
    structure, positions, _ = _block()
    dissection = nested_dissection(structure, positions, 100)
    unknowns = np.bincount(dissection.part, structure.sizes, len(dissection.parent))
    ends = np.setdiff1d(np.arange(len(dissection.parent)), dissection.parent)
    assert unknowns[ends].max() <= 100


def test_separators_consist_of_images_and_curves_go_with_their_images() -> None:
    structure, positions, n_images = _block()
    dissection = nested_dissection(structure, positions, 200)
    separates = np.isin(dissection.part, dissection.parent)
    assert separates[:n_images].sum() > 0.2 * n_images
    assert separates[n_images:].sum() <= 0.02 * 3 * n_images


def test_global_nodes_are_eliminated_last() -> None:
    grid, positions = _grid(20, 12)
    n = grid.n_nodes
    sizes = np.r_[grid.sizes, 3, 40]
    every = np.arange(n)
    structure = BlockStructure.from_pairs(
        sizes,
        np.r_[grid.rows, every, every, n],
        np.r_[grid.cols, every * 0 + n, every * 0 + n + 1, n + 1],
    )
    place = np.r_[positions, np.full((2, 2), np.nan)]
    dissection = nested_dissection(structure, place, 60)
    assert np.flatnonzero(dissection.part == ROOT).tolist() == [n, n + 1]
    tree = build_fronts(structure, dissection)
    assert {n, n + 1} <= set(tree.order[tree.first[-2] :].tolist())
    without_place = nested_dissection(structure, None, 60)
    assert np.flatnonzero(without_place.part == ROOT).tolist() == [n, n + 1]


def test_a_node_without_position_is_global_however_few_it_couples_with() -> None:
    structure, positions = _grid(20, 12)
    positions[37] = np.nan
    assert np.flatnonzero(nested_dissection(structure, positions, 60).part == ROOT).tolist() == [37]


def test_small_fronts_are_merged() -> None:
    """In a chain of single unknowns separators of one unknown are not worth a front."""
    n = 1000
    structure = BlockStructure.from_pairs(np.ones(n), np.arange(n - 1), np.arange(1, n))
    dissection = nested_dissection(structure, None, 60)
    assert len(build_fronts(structure, dissection).parent) < 0.5 * len(np.unique(dissection.part))


def test_positions_do_not_mislead_where_they_are_good() -> None:
    """The graph of the images alone is as fine as their positions: either way costs about the same."""
    structure, positions, _ = _block()
    assert analyse(structure, positions).flops < 1.1 * analyse(structure, None).flops


def test_operations_of_a_grid_are_those_of_nested_dissection() -> None:
    """829/84 m³ multiplications and as many additions on an m x m grid (George 1973), times 6³.

    Terms of order m² log m and merged fronts may add a tenth; a band needs 3.4 times as many.
    """
    m = 64
    symbolic = analyse(*_grid(m, m))
    assert symbolic.flops < 1.1 * 2.0 * 829.0 / 84.0 * m**3 * 6**3


@pytest.mark.parametrize("misled", ["shuffled", "one place", "none"])
def test_the_graph_replaces_positions_that_mislead(misled: str) -> None:
    """Within 1.5 times the operations of true positions; bisecting shuffled ones needs 88 times."""
    structure, positions = _grid(40, 25)
    replaced = {
        "shuffled": np.random.default_rng(2).permutation(positions),
        "one place": np.zeros_like(positions),
        "none": np.full_like(positions, np.nan),
    }[misled]
    assert analyse(structure, replaced).flops < 1.5 * analyse(structure, positions).flops


def test_height_differences_between_images_and_curves_do_not_mislead() -> None:
    structure, positions, _ = _block()
    lifted = positions * [1.0, 1.0, 100.0]
    assert analyse(structure, lifted).flops < 1.1 * analyse(structure, positions[:, :2]).flops


def test_rows_of_fronts_hold_the_fill() -> None:
    """The fill by eliminating node after node in the order of the tree lies inside the fronts."""
    structure, positions, _ = _block(4, 8)
    tree = build_fronts(structure, nested_dissection(structure, positions, 60))
    n = structure.n_nodes
    position = np.argsort(tree.order)
    filled = np.zeros((n, n), dtype=bool)
    filled[position[structure.rows], position[structure.cols]] = True
    filled |= filled.T
    held = np.zeros((n, n), dtype=bool)
    for front in range(len(tree.parent)):
        pivots = np.arange(tree.first[front], tree.first[front + 1])
        held[np.ix_(pivots, np.r_[pivots, tree.rows(front)])] = True
        if len(tree.rows(front)):
            parent = tree.parent[front]
            assert tree.first[parent] <= tree.rows(front)[0] < tree.first[parent + 1]
    for k in range(n):
        later = k + np.flatnonzero(filled[k, k:])
        filled[np.ix_(later, later)] = True
    assert len(tree.parent) > 3
    assert not np.any(np.triu(filled) & ~held)


@pytest.mark.parametrize("seed", range(12))
def test_separator_is_the_lightest(seed: int) -> None:
    """Against all subsets of a random graph of eleven nodes."""
    rng = np.random.default_rng(seed)
    n, band = 11, 0.2
    i, j = np.triu_indices(n, 1)
    chosen = rng.random(len(i)) < 0.3
    edges = np.stack([i[chosen], j[chosen]])
    weights = rng.integers(1, 9, n)
    fraction = rng.permutation((np.arange(n) + 0.5) / n)
    side = vertex_separators(weights, edges, fraction, band)
    assert not np.any((side[edges[0]] == FIRST) & (side[edges[1]] == SECOND))
    assert not np.any((side[edges[0]] == SECOND) & (side[edges[1]] == FIRST))
    assert np.all(side[fraction < 0.5 - band] != SECOND)
    assert np.all(side[fraction > 0.5 + band] != FIRST)
    lightest = min(
        weights[list(removed)].sum()
        for k in range(n + 1)
        for removed in combinations(range(n), k)
        if _separates(set(removed), edges, fraction, band)
    )
    assert weights[side == SEPARATOR].sum() == lightest


def _separates(removed: set[int], edges: np.ndarray, fraction: np.ndarray, band: float) -> bool:
    reached = {v for v in range(len(fraction)) if fraction[v] < 0.5 - band} - removed
    grown = True
    while grown:
        grown = False
        for u, v in edges.T.tolist():
            for a, b in ((u, v), (v, u)):
                if a in reached and b not in reached and b not in removed:
                    reached.add(b)
                    grown = True
    return all(fraction[v] <= 0.5 + band for v in reached)
