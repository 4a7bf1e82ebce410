"""Polynomials on [0, 1] in Bernstein form, many at once: p(t) = sum_k b_k C(d, k) t^k (1 - t)^(d - k).

The values of p lie among its coefficients, p has no more roots in (0, 1) than these have changes of sign, and both
statements hold for the halves too, whose coefficients are means of means (de Casteljau): what is decided here is
decided for every t.  The coefficients are the first axis of all arrays, what is many the last.
"""

from __future__ import annotations

from math import comb

import numpy as np

from splinebba_cli.core.network import FloatArray


def from_powers(powers: FloatArray) -> FloatArray:
    """Bernstein coefficients of sum_k a_k t^k, of the same shape (d + 1, ...)."""
    degree = len(powers) - 1
    matrix = np.array(
        [
            [comb(i, k) / comb(degree, k) if k <= i else 0.0 for k in range(degree + 1)]
            for i in range(degree + 1)
        ]
    )
    return np.asarray(np.tensordot(matrix, powers, axes=1))


def to_powers(b: FloatArray) -> FloatArray:
    """Coefficients of the powers of t, of the same shape (d + 1, k)."""
    degree = len(b) - 1
    matrix = np.array(
        [
            [comb(degree, k) * comb(k, i) * (-1.0) ** (k - i) if i <= k else 0.0 for i in range(degree + 1)]
            for k in range(degree + 1)
        ]
    )
    return np.asarray(matrix @ b)


def halves(b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same polynomials on [0, 1/2] and on [1/2, 1], each again on [0, 1]."""
    left, right = np.empty_like(b), np.empty_like(b)
    row = b
    for k in range(len(b)):
        left[k], right[-1 - k] = row[0], row[-1]
        row = 0.5 * (row[:-1] + row[1:])
    return left, right


def value_and_slope(b: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """p(t) and p'(t), by de Casteljau, (...) each.

    Parameters
    ----------
    b : (d + 1, ..., k)
    t : (k,)
    """
    row, s = b, 1.0 - t
    while len(row) > 2:
        row = s * row[:-1] + t * row[1:]
    return s * row[0] + t * row[1], (len(b) - 1) * (row[1] - row[0])
