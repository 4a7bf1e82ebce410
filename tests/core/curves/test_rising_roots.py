"""Roots where polynomials rise: known ones, however near, and none that is not there."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import polynomial

from splinebba_cli.core.curves.bernstein import from_powers
from splinebba_cli.core.curves.rising_roots import Minima, rising_roots
from splinebba_cli.core.network import FloatArray


def of_roots(*roots: float, factor: float = 1.0) -> FloatArray:
    """Bernstein coefficients (8, 1) of a polynomial of degree 7 with these roots; others are at 3."""
    powers = polynomial.polyfromroots([*roots, *[3.0] * (7 - len(roots))])
    sign = (-1.0) ** (7 - len(roots))  # the distant ones are passed over from below
    return from_powers(factor * sign * powers[:, None])


def found(b: FloatArray) -> FloatArray:
    return np.sort(rising_roots(b).t)


def test_of_random_roots_every_other_one_rises() -> None:
    g = np.random.default_rng(1)
    for _ in range(300):
        number = int(g.integers(1, 8))
        roots = np.sort(g.uniform(-0.5, 1.5, number))
        rising = roots[(np.arange(number) - number) % 2 == 1]
        inside = rising[(rising > 0.0) & (rising < 1.0)]
        if number > 1 and np.diff(roots).min() < 1e-3:
            continue
        np.testing.assert_allclose(found(of_roots(*roots)), inside, atol=1e-9)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_near_roots_are_told_apart(gap: float) -> None:
    # the middle one falls
    np.testing.assert_allclose(found(of_roots(0.3, 0.3 + gap)), [0.3 + gap], atol=1e-8)
    np.testing.assert_allclose(found(of_roots(0.7, 0.3 + gap, 0.3)), [0.3, 0.7], atol=1e-8)


@pytest.mark.parametrize("at", [0.5, 0.25, 0.625, 0.3])
def test_a_root_where_an_interval_is_halved_is_not_lost(at: float) -> None:
    b = of_roots(at, 0.1, 0.9)  # three changes of sign: halved
    np.testing.assert_allclose(found(b), [0.1, 0.9], atol=1e-12)
    np.testing.assert_allclose(found(-b), [at], atol=1e-12)


def test_a_root_exactly_in_the_middle_is_not_lost() -> None:
    """Antisymmetric coefficients: 0 at 1/2 to the last digit, and no change of sign is left on either side of it."""
    b = np.array([1.0, -6.0, -1.0, -1.0, 1.0, 1.0, 6.0, -1.0])[:, None]
    assert found(b).tolist() == [0.5]
    assert len(found(-b)) == 2


@pytest.mark.parametrize("at", [0.5, 0.3])
def test_multiple_roots(at: float) -> None:
    """A polynomial that touches 0 does not rise through it; a triple root is one, as well as its noise allows."""
    touching = of_roots(at, at)
    assert len(found(touching)) <= 1  # to rounding it may pass through 0 twice, 1e-8 apart
    np.testing.assert_allclose(found(touching), at, atol=1e-6)
    np.testing.assert_allclose(found(of_roots(at, at, at)), [at], atol=1e-4)


def test_ends() -> None:
    """A root at an end is none inside; the signs beside the ends tell what happens there."""
    for b, first, last in ((of_roots(0.0), 1, 1), (of_roots(1.0), -1, -1), (of_roots(0.0, 1.0), -1, -1)):
        roots = rising_roots(b)
        assert not len(roots.t)
        assert (roots.first_sign[0], roots.last_sign[0]) == (first, last)
    assert rising_roots(np.zeros((8, 1))).first_sign[0] == 0.0


def test_many_polynomials_at_once() -> None:
    """Degenerate degrees beside full ones, in one call: each its own column."""
    line = np.linspace(-1.0, 3.0, 8)[:, None]
    b = np.concatenate(
        [of_roots(0.2, 0.4, 0.6), line, np.zeros((8, 1)), -line, of_roots(0.5, factor=1e-30)], axis=1
    )
    roots = rising_roots(b)
    order = np.lexsort((roots.t, roots.column))
    assert roots.column[order].tolist() == [0, 0, 1, 4]
    np.testing.assert_allclose(roots.t[order], [0.2, 0.6, 0.25, 0.5], atol=1e-12)
    minima = Minima.of(b)
    ends = {(int(c), int(e)) for c, e in zip(minima.column, minima.end, strict=True) if e}
    assert ends == {(2, -1), (2, 1), (3, -1), (3, 1)}  # nowhere rising, and falling last, rising first


def test_no_polynomials() -> None:
    assert not len(Minima.of(np.zeros((8, 0))).t)
