"""Polynomials on [0, 1] in Bernstein form, many at once: p(t) = sum_k b_k C(d, k) t^k (1 - t)^(d - k).

The values of p lie among its coefficients, p has no more roots in (0, 1) than these have changes of sign, and both
statements hold for the halves too, whose coefficients are means of means (de Casteljau): what is decided here is
decided for every t.  The coefficients are the first axis of all arrays, what is many the last.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np

from splinebba_cli.core.network import FloatArray


def from_powers(powers: FloatArray) -> FloatArray:
    """Bernstein coefficients of sum_k a_k t^k, of the same shape (d + 1, ...)."""
    return np.asarray(np.tensordot(_bernstein_of_powers(len(powers) - 1), powers, axes=1))


def to_powers(b: FloatArray) -> FloatArray:
    """Coefficients of the powers of t, of the same shape (d + 1, ...)."""
    return np.asarray(np.tensordot(_powers_of_bernstein(len(b) - 1), b, axes=1))


@lru_cache
def _bernstein_of_powers(degree: int) -> FloatArray:
    """b_i = sum_k C(i, k) / C(d, k) a_k."""
    each = range(degree + 1)
    return np.array([[comb(i, k) / comb(degree, k) for k in each] for i in each])


@lru_cache
def _powers_of_bernstein(degree: int) -> FloatArray:
    """a_k = sum_i C(d, k) C(k, i) (-1)^(k - i) b_i."""
    each = range(degree + 1)
    return np.array([[comb(degree, k) * comb(k, i) * (-1.0) ** (k - i) for i in each] for k in each])


def halves(b: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same polynomials on [0, 1/2] and on [1/2, 1], each again on [0, 1]."""
    left, right = np.empty_like(b), np.empty_like(b)
    row = b
    for k in range(len(b)):
        left[k], right[-1 - k] = row[0], row[-1]
        row = 0.5 * (row[:-1] + row[1:])
    return left, right


def basis_values(degree: int, t: FloatArray) -> FloatArray:
    """C(d, k) t^k (1 - t)^(d - k), (q, d + 1) at t (q,)."""
    k = np.arange(degree + 1)
    binomial = np.array([comb(degree, each) for each in k], dtype=float)
    return np.asarray(binomial * t[:, None] ** k * (1.0 - t[:, None]) ** (degree - k))


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
