"""Numerical rank of a design matrix: what is zero up to rounding.

With columns of unit length the largest singular value lies between 1 and √n, and every entry carries an error of some
rounding units of its column, so that ‖E‖ ≤ OPERATIONS ε √n.  A singular value up to this bound cannot be told from 0;
one above it is none.  How weakly it is determined is another question
(:mod:`~splinebba_cli.core.quality.determinacy`).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray

OPERATIONS = 100.0  # projection, rotation, whitening, elimination: roundings that an entry has gone through


def rounding_limit(columns: int) -> float:
    """Largest singular value, columns of unit length, that rounding alone can make."""
    return OPERATIONS * float(np.finfo(np.float64).eps) * float(np.sqrt(max(columns, 1)))


def scaled_columns(matrix: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Columns of unit length, and which are not zero."""
    length = np.linalg.norm(matrix, axis=0)
    reached = np.asarray(length > 0.0)
    return matrix / np.where(reached, length, 1.0), reached


def numerical_rank(matrix: FloatArray) -> int:
    """Number of singular values above rounding."""
    scaled, reached = scaled_columns(matrix)
    scaled = scaled[:, reached]
    if not scaled.size:
        return 0
    if len(scaled) > scaled.shape[1]:
        scaled = np.asarray(np.linalg.qr(scaled, mode="r"))  # the same singular values, from a smaller matrix
    singular = np.linalg.svd(scaled, compute_uv=False)
    return int(np.count_nonzero(singular > rounding_limit(scaled.shape[1])))
