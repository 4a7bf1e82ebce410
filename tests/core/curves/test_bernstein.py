"""Bernstein's form: conversions, halves, values and slopes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import polynomial

from splinebba_cli.core.curves.bernstein import from_powers, halves, to_powers, value_and_slope


@pytest.mark.parametrize("degree", [1, 3, 5, 7])
def test_all_forms_are_the_same_polynomial(degree: int) -> None:
    g = np.random.default_rng(degree)
    a, t = g.normal(size=(degree + 1, 20)), g.uniform(-0.5, 1.5, 20)
    b = from_powers(a)
    expected = polynomial.polyval(t, a, tensor=False)
    slope = polynomial.polyval(t, polynomial.polyder(a), tensor=False)
    np.testing.assert_allclose(to_powers(b), a, atol=1e-11)
    value, rate = value_and_slope(b, t)
    np.testing.assert_allclose(value, expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(rate, slope, rtol=1e-9, atol=1e-9)
    left, right = halves(b)
    np.testing.assert_allclose(value_and_slope(left, 2.0 * t)[0], expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(value_and_slope(right, 2.0 * t - 1.0)[0], expected, rtol=1e-9, atol=1e-9)


def test_components_are_polynomials_of_their_own() -> None:
    g = np.random.default_rng(3)
    a = g.normal(size=(4, 3, 10))
    value, slope = value_and_slope(from_powers(a), np.full(10, 0.25))
    np.testing.assert_allclose(value, polynomial.polyval(0.25, a), rtol=1e-12)
    np.testing.assert_allclose(slope, polynomial.polyval(0.25, polynomial.polyder(a)), rtol=1e-12)
