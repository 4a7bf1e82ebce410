"""Cardinal and Catmull-Rom splines against scipy's Hermite splines."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray


def curve(count: int, **options: object) -> Curve:
    knots = np.cumsum(np.random.default_rng(count).normal(0.0, 10.0, (count, 3)), axis=0)
    return replace(Curve("c", "tie", "cardinal", knots, np.full_like(knots, np.inf)), **options)  # type: ignore[arg-type]


def tangents(u: FloatArray, knots: FloatArray, closed: bool, tension: float) -> FloatArray:
    """(1 - tension) (P_{i+1} - P_{i-1}) / (u_{i+1} - u_{i-1}), one-sided at the ends."""
    out = np.empty_like(knots)
    period = u[-1] - u[0]
    for i in range(len(knots)):
        a, b = i - 1, i + 1
        if not closed:
            a, b = max(a, 0), min(b, len(knots) - 1)
        n = len(knots)
        step = (u[b % n] + period * (b // n)) - (u[a % n] + period * (a // n)) if closed else u[b] - u[a]
        out[i] = (1.0 - tension) * (knots[b % n] - knots[a % n]) / step
    return out


@pytest.mark.parametrize("parameterization", ["uniform", "chord_length"])
@pytest.mark.parametrize("tension", [-0.5, 0.0, 0.7])
@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
@pytest.mark.parametrize("count", [2, 3, 4, 5, 9])
def test_curve_equals_scipy(count: int, closed: bool, tension: float, parameterization: str) -> None:
    if closed and count < 3:
        pytest.skip("a closed spline needs three knots")
    one = curve(count, closed=closed, tension=tension, parameterization=parameterization)
    basis = basis_of(one)
    u, slope = basis.break_points, tangents(basis.break_points, one.values, closed, tension)
    knots = one.values
    if closed:
        knots, slope = np.vstack([knots, knots[:1]]), np.vstack([slope, slope[:1]])
    oracle = CubicHermiteSpline(u, knots, slope)
    places = np.random.default_rng(1).uniform(u[0], u[-1], 50)
    for order in (0, 1, 2):
        expected = oracle(places, order)
        found = basis.evaluate(places, one.values, order)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * max(1.0, np.abs(expected).max()))


def test_catmull_rom_is_tension_zero() -> None:
    one, other = curve(6, tension=0.5), curve(6, family="catmull_rom", tension=0.5)
    u = np.linspace(0.0, basis_of(one).break_points[-1], 20)
    zero = basis_of(replace(one, tension=0.0)).evaluate(u, one.values)
    np.testing.assert_array_equal(basis_of(other).evaluate(u, one.values), zero)
    assert np.abs(basis_of(one).evaluate(u, one.values) - zero).max() > 0.1


@pytest.mark.parametrize("tension", [-1.1, 1.0, 2.0])
def test_tensions_without_a_curve_are_refused(tension: float) -> None:
    """1 makes a polygon with stops at its knots: no direction there."""
    with pytest.raises(ValueError, match="tension"):
        basis_of(curve(5, tension=tension))
