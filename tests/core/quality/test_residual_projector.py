"""Sparse rows and R = I - A Q A' against the dense system.

The dense R comes from a QR factorisation; the block Cholesky works with the square of the condition (1e3): 1e6 times
rounding leaves nine digits of 1.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import sparse

from splinebba_cli.core.estimation import sparse_design
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from tests.core.small_networks import DenseSystem, dense_system, mixed_network, solved

TOLERANCE = 1e-8


@cache
def systems() -> tuple[ResidualProjector, DenseSystem, FloatArray]:
    found = solved(mixed_network()[0])
    dense = dense_system(found.assembler, found.solution.linearization)
    q = np.linalg.qr(dense.design / np.linalg.norm(dense.design, axis=0))[0]
    return ResidualProjector(found.assembler, found.solution), dense, np.eye(len(q)) - q @ q.T


def test_rows_are_those_of_the_dense_design() -> None:
    """Rows of curve points come another way than those of the dense design: equal to rounding of their sizes.

    Residuals are differences of photo coordinates of 1e5 sigma, good to some 1e-16 of these.
    """
    projector, dense, _ = systems()
    design = projector.design
    both = np.hstack([design.reduced.toarray(), design.points.toarray()])
    size = np.linalg.norm(dense.design, axis=1)[:, None]
    np.testing.assert_allclose(both[:, dense.unknown] / size, dense.design / size, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(design.residual, dense.residual, rtol=0.0, atol=1e-10)
    removed = np.setdiff1d(np.arange(both.shape[1]), dense.unknown)
    assert len(removed) and not both[:, removed].any()


def test_errors_are_projected_as_by_the_dense_matrix() -> None:
    projector, _, r = systems()
    errors = np.random.default_rng(1).standard_normal((len(r), 4))
    np.testing.assert_allclose(projector.project(errors), r @ errors, rtol=0.0, atol=TOLERANCE)


def test_products_with_the_rows_in_two_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sums of two halves: equal to rounding of the terms."""
    monkeypatch.setattr(sparse_design, "WORTH_THREADS", 2)
    design = replace(systems()[0].design)
    errors = np.random.default_rng(3).standard_normal((design.ranges.count, 3))
    over, matrix = design.over_unknowns(errors), design.reduced.toarray()
    np.testing.assert_allclose(
        over, matrix.T @ errors, rtol=0.0, atol=1e-13 * np.abs(matrix).sum(axis=0).max()
    )
    np.testing.assert_array_equal(design.on_rows(over), design.reduced @ over)


def last_step() -> float:
    """Length of the last, undamped step, in units of the sigma of the unknowns: |A d|."""
    return systems()[0].solution.iterations[-1].step


def test_the_residuals_are_their_own_projection_but_for_the_last_step() -> None:
    """v - R v = A Q A'v = - A d with d the undamped step at the solution; to rounding of sums of 500 squares."""
    projector, _, _ = systems()
    v = projector.design.residual[:, None]
    assert np.linalg.norm(projector.project(v) - v) == pytest.approx(last_step(), rel=1e-5, abs=1e-9)


def test_small_blocks_of_directions() -> None:
    projector, _, r = systems()
    generator = np.random.default_rng(2)
    blocks = [sparse.random_array((len(r), k), density=0.05, rng=generator).tocsc() for k in (1, 3, 2, 1)]
    for block, (inner, gram) in zip(blocks, projector.grams(blocks), strict=True):
        c = block.toarray()
        np.testing.assert_allclose(inner, c.T @ c, rtol=1e-13)
        np.testing.assert_allclose(gram, c.T @ r @ c, rtol=0.0, atol=TOLERANCE * np.abs(inner).max())
