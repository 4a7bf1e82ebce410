"""Rank of the measurements, and the null directions in the user's words.

Small networks: singular values of the design matrix with columns scaled to unit length, against the bound of rounding
(:mod:`~splinebba_cli.core.estimation.numerical_rank`).  Large ones: the smallest eigenvalues of the reduced normal
matrix, scaled to a unit diagonal.  Where N - s diag N has a Cholesky factor all of them exceed s and nothing is
singular; else subspace iteration with a shifted factor finds them.  (theory, section 6: diagnose, never guess)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import NotPositiveDefinite
from splinebba_cli.core.estimation.block_matrix import BlockMatrix
from splinebba_cli.core.estimation.design_matrix import DesignMatrix, design_matrix, unknown_count
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.numerical_rank import rounding_limit, scaled_columns
from splinebba_cli.core.network import FloatArray

DENSE_LIMIT = 1500  # unknowns up to which the design matrix is decomposed
CLEAR = 1e-9  # eigenvalue of the scaled normal matrix from which nothing needs a closer look
SHIFT = 1e-10
EIGEN_ZERO = 1e-11


@dataclass(frozen=True)
class NullSpace:
    """Directions that no equation determines."""

    unknowns: int
    rank: int
    vectors: FloatArray  # (nullity, N + 3 n) over reduced unknowns, then points; columns of unit scale

    @property
    def nullity(self) -> int:
        """Number of undetermined directions."""
        return self.unknowns - self.rank


def null_space(assembler: Assembler, at: Linearization) -> NullSpace:
    """Null directions of all equations of an assembler at a state."""
    if unknown_count(assembler.layout) <= DENSE_LIMIT:
        return _dense_null_space(assembler, design_matrix(assembler, at))
    return _sparse_null_space(assembler, at)


def _dense_null_space(assembler: Assembler, design: DesignMatrix) -> NullSpace:
    width = int(assembler.layout.node_starts[-1]) + assembler.layout.point_mask.size
    columns = design.matrix.shape[1]
    if not columns:
        return NullSpace(0, 0, np.zeros((0, width)))
    scaled, reached = scaled_columns(design.matrix)
    if reached.all() and _clearly_regular(scaled):
        return NullSpace(columns, columns, np.zeros((0, width)))
    matrix = np.vstack([scaled, np.zeros((max(0, columns - len(scaled)), columns))])
    _, singular, right = np.linalg.svd(matrix, full_matrices=False)
    zero = singular <= rounding_limit(columns)
    vectors = np.zeros((int(zero.sum()), width))
    vectors[:, design.unknown] = right[zero]
    return NullSpace(columns, columns - len(vectors), vectors)


def _clearly_regular(scaled: FloatArray) -> bool:
    """Whether all singular values exceed the root of CLEAR: a Cholesky factorisation costs less than they do."""
    try:
        np.linalg.cholesky(scaled.T @ scaled - CLEAR * np.eye(scaled.shape[1]))
    except np.linalg.LinAlgError:
        return False
    return True


def _no_small_eigenvalue(
    assembler: Assembler, at: Linearization, values: FloatArray, diagonal: FloatArray
) -> bool:
    """Whether N - SHIFT diag N is positive definite: then no eigenvalue of the scaled N is below SHIFT (Sylvester)."""
    try:
        assembler.symbolic(at.state).factorize(values, damping=-SHIFT * diagonal)
    except NotPositiveDefinite:
        return False
    return True


def _sparse_null_space(assembler: Assembler, at: Linearization, start: int = 12) -> NullSpace:
    structure = assembler.structure
    values, _, eliminated = assembler.eliminate(at, 0.0)
    diagonal = np.maximum(BlockMatrix(structure, values).diagonal(), 1e-300)
    matrix = BlockMatrix(structure, values)
    mask, unknowns = assembler.mask, unknown_count(assembler.layout)
    root = np.sqrt(diagonal)
    if _no_small_eigenvalue(assembler, at, values, diagonal):
        return NullSpace(unknowns, unknowns, np.zeros((0, len(root) + eliminated.right_side.size)))
    try:
        factor = assembler.symbolic(at.state).factorize(values, damping=SHIFT * diagonal)
    except NotPositiveDefinite:
        factor = assembler.symbolic(at.state).factorize(values, damping=1e-6 * diagonal)
    generator = np.random.default_rng(20081)
    size = min(start, len(root))
    while True:
        basis = np.linalg.qr(generator.standard_normal((len(root), size)))[0]
        for _ in range(4):
            basis = np.linalg.qr(root[:, None] * factor.solve(root[:, None] * basis))[0]
        image = np.column_stack([matrix.multiply(basis[:, k] / root) / root for k in range(size)])
        eigenvalues, vectors = np.linalg.eigh(basis.T @ image)
        zero = np.flatnonzero(eigenvalues < EIGEN_ZERO)
        if len(zero) < size or size >= len(root):
            break
        size = min(4 * size, len(root))
    found = (basis @ vectors[:, zero]).T * mask
    width = len(root) + eliminated.right_side.size
    padded = np.zeros((len(found), width))
    padded[:, : len(root)] = found
    return NullSpace(unknowns, unknowns - len(found), padded)
