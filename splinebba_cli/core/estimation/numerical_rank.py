"""Numerical rank of design matrices: what is zero up to rounding.

With columns of unit length the largest singular value lies between 1 and √n, and every entry carries an error of some
rounding units of its column, so that ‖E‖ ≤ OPERATIONS ε √n.  A singular value up to this bound cannot be told from 0;
one above it is none.  How weakly it is determined is another question
(:mod:`~splinebba_cli.core.quality.determinacy`).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

OPERATIONS = 100.0  # projection, rotation, whitening, elimination: roundings that an entry has gone through


def rounding_limit(columns: int) -> float:
    """Largest singular value, columns of unit length, that rounding alone can make."""
    return OPERATIONS * float(np.finfo(np.float64).eps) * float(np.sqrt(max(columns, 1)))


def scaled_columns(matrix: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Columns of unit length, and which are not zero, of one matrix or of a stack."""
    length = np.linalg.norm(matrix, axis=-2)
    reached = np.asarray(length > 0.0)
    return matrix / np.where(reached, length, 1.0)[..., None, :], reached


def numerical_ranks(matrices: FloatArray) -> IntArray:
    """Number of singular values above rounding of every matrix (g, rows, columns), (g,); zero rows change nothing."""
    return nested_ranks(matrices, matrices.shape[2])[1]


def nested_ranks(matrices: FloatArray, leading: int) -> tuple[IntArray, IntArray]:
    """Ranks of the leading columns, and of all, of every matrix (g, rows, columns), (g,) each.

    A = Q R: the leading columns of A have the singular values of those of R.
    """
    scaled, reached = scaled_columns(matrices)
    if scaled.shape[1] > scaled.shape[2]:
        scaled = np.asarray(np.linalg.qr(scaled, mode="r"))
    every = _ranks(scaled, reached)
    if leading == scaled.shape[2]:
        return every, every
    return _ranks(scaled[:, :, :leading], reached[:, :leading]), every


def _ranks(scaled: FloatArray, reached: BoolArray) -> IntArray:
    """Numbers of singular values above the bound of the columns that are not zero."""
    if not scaled.size:
        return np.zeros(len(scaled), dtype=np.int64)
    limits = rounding_limit(1) * np.sqrt(np.maximum(np.count_nonzero(reached, axis=1), 1))
    singular = np.linalg.svd(scaled, compute_uv=False)
    return np.asarray(np.count_nonzero(singular > limits[:, None], axis=1))
