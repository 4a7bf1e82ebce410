"""Fill of the factor against multiple minimum degree, where positions mislead or the pattern is no plain block.

The other program is SuperLU (permc_spec MMD_AT_PLUS_A, symmetric mode) on the same pattern.  Merging of small fronts,
which computes zeros on purpose, is switched off, so that orderings are compared.  Dissection of small blocks is
allowed twice the operations of minimum degree and half as many entries again; an ordering that misses the shape of a
pattern loses by factors of 3 to 100.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from splinebba_cli.core import speed
from splinebba_cli.core.estimation import block_cholesky
from splinebba_cli.core.estimation.block_matrix import BlockMatrix, BlockStructure
from splinebba_cli.core.estimation.fronts import FrontCosts

ENTRIES, OPERATIONS = 1.5, 2.0

Pattern = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _block(length: int = 40, strips: int = 4, reach: tuple[float, float] = (1.3, 1.6)) -> Pattern:
    """Images of strips 2 apart, 2.5 short curves per image in reach."""
    rng = np.random.default_rng(3)
    strip, along = np.divmod(np.arange(length * strips), length)
    image = np.c_[along, 2.0 * strip, np.full(len(strip), 5.0)]
    n_curves = 5 * len(image) // 2
    curve = rng.uniform([0, 0, 0], [length - 1, 2.0 * (strips - 1) + 1e-3, 0.01], (n_curves, 3))
    away = np.abs(curve[:, None, :2] - image[None, :, :2]) / reach
    c, i = np.nonzero((away**2).sum(axis=2) < 1.0)
    sizes = np.r_[np.full(len(image), 6), np.full(n_curves, 15)]
    return sizes, i, len(image) + c, np.r_[image, curve]


def strip() -> Pattern:
    return _block(160, 1, (2.5, 2.0))


def _orbit(reach: float, n_curves: int, n_images: int = 60) -> Pattern:
    """Images on a circle that look inward; a curve is seen from so far (radians) on either side."""
    rng = np.random.default_rng(4)
    image, curve = 2.0 * np.pi * np.arange(n_images) / n_images, rng.uniform(0.0, 2.0 * np.pi, n_curves)
    away = np.abs((image[None] - curve[:, None] + np.pi) % (2.0 * np.pi) - np.pi)
    c, i = np.nonzero(away < reach)
    place = np.r_[np.c_[10.0 * np.cos(image), 10.0 * np.sin(image)], np.c_[np.cos(curve), np.sin(curve)]]
    return np.r_[np.full(n_images, 6), np.full(n_curves, 15)], i, n_images + c, place


def orbit_of_near_features() -> Pattern:
    return _orbit(0.2, 150)


def orbit_of_features_seen_from_a_fifth() -> Pattern:
    return _orbit(0.6, 150)


def orbit_of_features_seen_from_everywhere() -> Pattern:
    return _orbit(4.0, 30)


def _with(
    pattern: Pattern, sizes: np.ndarray, rows: np.ndarray, cols: np.ndarray, place: np.ndarray
) -> Pattern:
    return (
        np.r_[pattern[0], sizes], np.r_[pattern[1], rows], np.r_[pattern[2], cols], np.r_[pattern[3], place],
    )  # fmt: skip


def _long_curve(pattern: Pattern, place: np.ndarray, n_nodes: int = 80) -> Pattern:
    """A chain of nodes of four coefficients across the whole block."""
    sizes, _, _, positions = pattern
    line = np.c_[np.linspace(0.0, 39.0, n_nodes), np.linspace(0.0, 6.0, n_nodes)]
    images = positions[sizes == 6, :2]
    k, i = np.nonzero(np.linalg.norm(line[:, None] - images[None], axis=2) < 1.3)
    chain = len(sizes) + np.arange(n_nodes)
    return _with(
        pattern, np.full(n_nodes, 12), np.r_[i, chain[:-1]], np.r_[chain[k], chain[1:]],
        np.c_[line, np.zeros(n_nodes)] + place,
    )  # fmt: skip


def long_curve() -> Pattern:
    return _long_curve(_block(), np.zeros(3))


def long_curve_far_from_its_images() -> Pattern:
    return _long_curve(_block(), np.array([1e4, -1e4, 500.0]))


def curve_in_most_images() -> Pattern:
    rng, pattern = np.random.default_rng(5), _block()
    images = rng.choice(160, 120, replace=False)
    return _with(pattern, np.array([24]), images, np.full(120, len(pattern[0])), np.zeros((1, 3)))


def curves_in_scattered_images() -> Pattern:
    rng, pattern = np.random.default_rng(6), _block()
    curves = np.repeat(len(pattern[0]) + np.arange(5), 30)
    return _with(pattern, np.full(5, 24), rng.integers(0, 160, 150), curves, rng.uniform(0.0, 40.0, (5, 3)))


def _global(pattern: Pattern, place: float) -> Pattern:
    """A drift coupled with all images, an interior orientation coupled with images and curves."""
    n = len(pattern[0])
    rows, cols = np.r_[np.arange(n), np.arange(160)], np.r_[np.full(n, n), np.full(160, n + 1)]
    return _with(pattern, np.array([3, 8]), rows, cols, np.full((2, 3), place))


def global_nodes_without_position() -> Pattern:
    return _global(_block(), np.nan)


def global_nodes_with_position() -> Pattern:
    return _global(_block(), 0.0)


def three_cameras() -> Pattern:
    """Each interior orientation is coupled with a third of the images and with what they see."""
    pattern = _block()
    camera = len(pattern[0]) + np.arange(160) // 54
    return _with(
        pattern, np.full(3, 8), np.r_[np.arange(160), pattern[2]], np.r_[camera, camera[pattern[1]]],
        np.zeros((3, 3)),
    )  # fmt: skip


def _placed(place: Callable[[np.ndarray], np.ndarray]) -> Pattern:
    pattern = _block()
    return (*pattern[:3], place(pattern[3]))


def all_in_one_place() -> Pattern:
    return _placed(np.zeros_like)


def no_positions() -> Pattern:
    return _placed(lambda place: np.full_like(place, np.nan))


def shuffled() -> Pattern:
    return _placed(np.random.default_rng(7).permutation)


CASES = [
    _block, strip, orbit_of_near_features, orbit_of_features_seen_from_a_fifth,
    orbit_of_features_seen_from_everywhere, long_curve, long_curve_far_from_its_images, curve_in_most_images,
    curves_in_scattered_images, global_nodes_without_position, global_nodes_with_position, three_cameras,
    all_in_one_place, no_positions, shuffled,
]  # fmt: skip


def _minimum_degree(structure: BlockStructure) -> tuple[float, float]:
    """Entries and operations of the factor, column by column."""
    pattern = BlockMatrix(structure, np.ones(structure.n_entries)).to_dense()
    dominant = pattern + 2.0 * len(pattern) * np.eye(len(pattern))
    lower = splu(
        csc_array(dominant),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    ).L
    counts = np.diff(lower.indptr).astype(float)
    return float(counts.sum()), float((counts**2).sum())


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.__name__.strip("_"))
def test_fill_is_about_that_of_minimum_degree(
    case: Callable[[], Pattern], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(speed.VARIABLE, "never")
    monkeypatch.setattr(block_cholesky, "PLAIN", FrontCosts(0.0, 0.0))
    sizes, rows, cols, positions = case()
    structure = BlockStructure.from_pairs(sizes, rows, cols)
    symbolic = block_cholesky.analyse(structure, positions)
    n, r = symbolic.layout.pivots, symbolic.layout.rows
    entries, operations = _minimum_degree(structure)
    assert float((n * (n + 1) // 2 + n * r).sum()) <= ENTRIES * entries
    assert symbolic.flops <= OPERATIONS * operations
