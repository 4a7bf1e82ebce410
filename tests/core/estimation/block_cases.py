"""Symmetric positive definite block matrices of many shapes, to compare with dense linear algebra.

The matrices are diagonally dominant, hence well conditioned: 1e-10 relative leaves five digits for
rounding in matrices of a thousand unknowns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_matrix import BlockMatrix, BlockStructure

TOLERANCE = 1e-10

Maker = Callable[[np.random.Generator], tuple]


@dataclass
class Case:
    matrix: BlockMatrix
    positions: np.ndarray
    several_fronts: bool


def random_values(structure: BlockStructure, rng: np.random.Generator) -> np.ndarray:
    """Random symmetric values; the diagonal is twice the sum of the magnitudes in its row."""
    n = structure.n_nodes
    values = np.zeros(structure.n_entries)
    for b in range(len(structure.rows)):
        i, j = structure.rows[b], structure.cols[b]
        block = rng.uniform(-1.0, 1.0, (structure.sizes[i], structure.sizes[j]))
        if i == j:
            block = block + block.T
        values[structure.offsets[b] : structure.offsets[b + 1]] = block.ravel()
    total = np.abs(BlockMatrix(structure, values).to_dense()).sum(axis=1)
    for node, b in enumerate(structure.find(np.arange(n), np.arange(n))):
        size = structure.sizes[node]
        at = structure.offsets[b] + np.arange(size) * (size + 1)
        values[at] = 2.0 * total[structure.starts[node] : structure.starts[node + 1]] + 0.1
    return values


def geometric(rng: np.random.Generator, n: int = 90) -> tuple:
    place = rng.uniform(0.0, 1.0, (n, 3)) * [4.0, 1.0, 0.01]
    distance = np.linalg.norm(place[:, None] - place[None], axis=2)
    i, j = np.nonzero(np.triu(distance < 0.3, 1))
    return rng.integers(1, 25, n), i, j, place, True


def chain(rng: np.random.Generator, n: int = 70) -> tuple:
    i = np.arange(n - 1)
    return rng.integers(1, 25, n), i, i + 1, np.c_[np.arange(n), np.zeros(n)], True


def star_with_global(rng: np.random.Generator, n: int = 60) -> tuple:
    """A chain, node 7 coupled with everything, without position."""
    i = np.r_[np.arange(n - 1), np.full(n, 7)]
    j = np.r_[np.arange(1, n), np.arange(n)]
    place = np.c_[np.arange(n), np.zeros(n), np.zeros(n)].astype(float)
    place[7] = np.nan
    return rng.integers(1, 25, n), i, j, place, True


def one_node(rng: np.random.Generator) -> tuple:
    return np.array([24]), [], [], np.zeros((1, 3)), False


def components(rng: np.random.Generator, n: int = 60) -> tuple:
    """Three interleaved chains and single nodes, at positions that say nothing."""
    i = np.arange(n - 13)
    return rng.integers(1, 25, n), i, i + 3, rng.uniform(0.0, 1.0, (n, 2)), True


def no_positions(rng: np.random.Generator) -> tuple:
    sizes, i, j, place, _ = geometric(rng)
    return sizes, i, j, np.full_like(place, np.nan), True


def same_position(rng: np.random.Generator) -> tuple:
    sizes, i, j, place, _ = geometric(rng)
    return sizes, i, j, np.zeros_like(place), True


def complete(rng: np.random.Generator, n: int = 40) -> tuple:
    i, j = np.triu_indices(n, 1)
    return rng.integers(1, 25, n), j, i, rng.uniform(0.0, 1.0, (n, 3)), False


def curves_and_images(rng: np.random.Generator, n_images: int = 48, n_curves: int = 60) -> tuple:
    """Images in strips, short curves on neighbouring images, one long curve of linked nodes."""
    image = np.c_[np.arange(n_images) % 12, np.arange(n_images) // 12].astype(float)
    curve = np.r_[rng.uniform([0, 0], [11, 3], (n_curves, 2)), np.c_[np.arange(11) + 0.5, np.full(11, 1.5)]]
    distance = np.linalg.norm(curve[:, None] - image[None], axis=2)
    c, i = np.nonzero(distance < 0.9)
    link = n_images + n_curves + np.arange(10)
    sizes = np.r_[np.full(n_images, 6), np.full(n_curves, 15), np.full(11, 12)]
    place = np.r_[image, curve]
    return sizes, np.r_[n_images + c, link], np.r_[i, link + 1], place, True


MAKERS = [
    geometric,
    chain,
    star_with_global,
    one_node,
    components,
    no_positions,
    same_position,
    complete,
    curves_and_images,
]
every_case = pytest.mark.parametrize("maker", MAKERS, ids=lambda maker: maker.__name__)


def build(maker: Maker, seed: int = 20080101) -> Case:
    """The matrix of one maker, always the same."""
    rng = np.random.default_rng(seed)
    sizes, rows, cols, positions, several_fronts = maker(rng)
    structure = BlockStructure.from_pairs(sizes, rows, cols)
    return Case(BlockMatrix(structure, random_values(structure, rng)), positions, several_fronts)
