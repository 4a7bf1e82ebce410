"""Where polynomials become positive: all t in (0, 1) with p < 0 before and p > 0 behind, many polynomials at once.

Descartes: the coefficients of Bernstein's form have as many changes of sign as p has roots in (0, 1), or more by an
even number.  No change: no root.  One: one root, which Newton's method finds between brackets.  More: the polynomial is
halved.  So no root is lost, however near they lie; a root that Newton's method looks for is known to be single.  Where
changes of sign remain on an interval of 2^-50, its ends decide.

Of a derivative the rising roots are the minima: the roots that fall, and those that touch, are not looked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.bernstein import halves, to_powers
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

DEEPEST = 50  # halvings
STEPS = 120  # of Newton's method or of halving: one of two at least halves the step or the bracket
LAST_STEP = 1e-11  # of Newton's method, in t: its square is nothing
LAST_HALVING = 1e-15


@dataclass(frozen=True)
class RisingRoots:
    """Roots, and what polynomials do at both ends of [0, 1]."""

    column: IntArray  # (r,) polynomial of every root
    t: FloatArray  # (r,)
    first_sign: FloatArray  # (k,) sign behind 0, 0 where the polynomial vanishes
    last_sign: FloatArray  # (k,) sign before 1


@dataclass(frozen=True)
class Minima:
    """Local minima on [0, 1] of functions whose slopes have the signs of polynomials."""

    column: IntArray  # (r,) function
    t: FloatArray  # (r,)
    end: IntArray  # (r,) -1: at 0, from where the function rises; 1: at 1, to where it falls; 0: between

    @classmethod
    def of(cls, b: FloatArray) -> Minima:
        """From Bernstein coefficients (d + 1, k) of the polynomials; where one vanishes, both ends."""
        roots = rising_roots(b)
        start, stop = np.flatnonzero(roots.first_sign >= 0.0), np.flatnonzero(roots.last_sign <= 0.0)
        return cls(
            np.concatenate([roots.column, start, stop]),
            np.concatenate([roots.t, np.zeros(len(start)), np.ones(len(stop))]),
            np.repeat([0, -1, 1], [len(roots.t), len(start), len(stop)]),
        )


@dataclass(frozen=True)
class _Brackets:
    """Polynomials with one rising root each."""

    column: IntArray
    begin: FloatArray
    width: FloatArray
    b: FloatArray  # (d + 1, r)


def rising_roots(b: FloatArray) -> RisingRoots:
    """All rising roots of polynomials in (0, 1).

    Parameters
    ----------
    b : (d + 1, k) float, Bernstein coefficients

    Returns
    -------
    RisingRoots
        In no order; a root at 0 or 1 itself is none, but is seen in the signs beside the ends.
    """
    first_sign, last_sign, changes = _signs(b)
    column = np.arange(b.shape[1])
    begin = np.zeros(b.shape[1])
    found: list[_Brackets] = []
    middles: list[tuple[IntArray, FloatArray]] = []
    first, last = first_sign, last_sign
    for depth in range(DEEPEST + 1):
        rising = (changes == 1) & (last > 0.0)
        if depth == DEEPEST:
            rising |= (first < 0.0) & (last > 0.0)
        if rising.any():
            width = np.full(np.count_nonzero(rising), 0.5**depth)
            found.append(_Brackets(column[rising], begin[rising], width, b[:, rising]))
        doubtful = changes > 1
        if depth == DEEPEST or not doubtful.any():
            break
        left, right = halves(b[:, doubtful])
        column, begin = column[doubtful], begin[doubtful]
        first, last, changes = (
            np.concatenate(both) for both in zip(_signs(left), _signs(right), strict=True)
        )
        count, middle = len(column), begin + 0.5 ** (depth + 1)
        exact = (left[-1] == 0.0) & (last[:count] < 0.0) & (first[count:] > 0.0)
        middles.append((column[exact], middle[exact]))
        b = np.concatenate([left, right], axis=1)
        column, begin = np.concatenate([column, column]), np.concatenate([begin, middle])
    columns, roots = [pair[0] for pair in middles], [pair[1] for pair in middles]
    for each in found:
        columns.append(each.column)
        roots.append(each.begin + each.width * _single_root(each.b))
    none = np.zeros(0)
    return RisingRoots(
        np.concatenate([none.astype(np.int64), *columns]),
        np.concatenate([none, *roots]),
        first_sign,
        last_sign,
    )


def _signs(b: FloatArray) -> tuple[FloatArray, FloatArray, IntArray]:
    """Sign of the first and of the last coefficient that is not 0, and the number of changes, (k,) each."""
    sign = np.sign(b)
    last, changes = sign[0].copy(), np.zeros(b.shape[1], dtype=np.int64)
    first = last.copy()
    for row in sign[1:]:
        changes += row * last < 0.0
        last = np.where(row == 0.0, last, row)
        first = np.where(first == 0.0, row, first)
    return first, last, changes


def _single_root(b: FloatArray) -> FloatArray:
    """The only root of polynomials that rise from below to above, (r,)."""
    a = to_powers(b)
    t = _crossing_of_polygon(b)
    out = t.copy()
    low, high = np.zeros_like(t), np.ones_like(t)
    own, before = np.arange(len(t)), np.ones_like(t)
    for _ in range(STEPS):
        value, slope = _horner(a, t)
        high, low = np.where(value > 0.0, t, high), np.where(value > 0.0, low, t)
        with np.errstate(all="ignore"):
            step = value / slope
        trial = t - step
        fast = (trial >= low) & (trial <= high) & (np.abs(step) <= 0.5 * before)
        trial = np.where(fast, trial, 0.5 * (low + high))
        trial = np.where(value == 0.0, t, trial)
        moved = np.abs(trial - t)
        t, before = trial, moved
        out[own] = t
        going = moved > np.where(fast, LAST_STEP, LAST_HALVING)
        if not going.any():
            break
        own, t, low, high, before, a = (
            own[going],
            t[going],
            low[going],
            high[going],
            before[going],
            a[:, going],
        )
    return out


def _horner(a: FloatArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values and slopes of polynomials in powers of t (d + 1, r), (r,) each."""
    value, slope = a[-1].copy(), np.zeros_like(t)
    for row in a[-2::-1]:
        slope *= t
        slope += value
        value *= t
        value += row
    return value, slope


def _crossing_of_polygon(b: FloatArray) -> FloatArray:
    """Where the polygon of the coefficients crosses 0, (r,): the root itself of a polynomial of degree 1."""
    degree = len(b) - 1
    below: BoolArray = np.logical_and.accumulate(b <= 0.0, axis=0)
    place = np.clip(below.sum(axis=0) - 1, 0, degree - 1)
    every = np.arange(b.shape[1])
    lower, upper = b[place, every], b[place + 1, every]
    with np.errstate(all="ignore"):
        part = lower / (lower - upper)
    return np.asarray(np.clip((place + np.where(np.isfinite(part), part, 0.5)) / degree, 0.0, 1.0))
