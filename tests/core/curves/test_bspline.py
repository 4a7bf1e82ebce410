"""B-splines by their control points against scipy."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.bspline_tables import bspline_power_tables, clamped
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray


def control_points(count: int) -> FloatArray:
    return np.random.default_rng(count).normal(0.0, 20.0, (count, 3))


def curve(degree: int, count: int, **options: object) -> Curve:
    points = control_points(count)
    made = Curve("c", "tie", f"bspline_{degree}", points, np.full_like(points, np.inf))
    return replace(made, **options)  # type: ignore[arg-type]


def places(basis: CurveBasis) -> FloatArray:
    breaks = basis.break_points
    return np.random.default_rng(2).uniform(breaks[0], breaks[-1], 60)


@pytest.mark.parametrize("parameterization", ["uniform", "chord_length"])
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("more", [1, 2, 3, 9, 80])
def test_open_ones_equal_scipy(degree: int, more: int, parameterization: str) -> None:
    """Clamped knot vector, all derivatives that exist everywhere."""
    one = curve(degree, degree + more, parameterization=parameterization)
    basis = basis_of(one)
    breaks = basis.break_points
    knots = np.concatenate([[breaks[0]] * degree, breaks, [breaks[-1]] * degree])
    oracle, u = BSpline(knots, one.values, degree), places(basis)
    for order in range(degree):
        expected = oracle.derivative(order)(u) if order else oracle(u)
        found = basis.evaluate(u, one.values, order)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(basis.evaluate(breaks[[0, -1]], one.values), one.values[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("parameterization", ["uniform", "chord_length"])
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("count", [3, 4, 5, 11])
def test_closed_ones_equal_scipy(degree: int, count: int, parameterization: str) -> None:
    """Periodic knot vector and repeated control points; three control points are under a segment twice."""
    one = curve(degree, count, parameterization=parameterization, closed=True)
    basis = basis_of(one)
    lengths = np.diff(basis.break_points)
    turns = np.arange(-degree, count + degree)
    steps = lengths[turns % count]
    knots = basis.break_points[0] - lengths[np.arange(-degree, 0) % count].sum()
    extended = knots + np.concatenate([[0.0], np.cumsum(steps)])
    points = one.values[np.arange(count + degree) % count]
    u = places(basis)
    expected = BSpline(extended, points, degree)(u)
    np.testing.assert_allclose(basis.evaluate(u, one.values), expected, rtol=0.0, atol=1e-10)
    assert len(np.unique(np.concatenate([basis.columns, np.full((1, degree + 1), 0)]))) == count


def test_parameters_by_chord_length_are_averages() -> None:
    """Piegl and Tiller, eq. 9.8: inner knot j is the mean of chord parameters j .. j + degree - 1."""
    one = curve(3, 7)
    chords = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(one.values, axis=0), axis=1))])
    expected = [0.0, *(chords[j : j + 3].mean() for j in range(1, 4)), chords[-1]]
    np.testing.assert_allclose(basis_of(one).break_points, expected)
    np.testing.assert_allclose(
        basis_of(curve(1, 5)).break_points[-1],
        np.linalg.norm(np.diff(control_points(5), axis=0), axis=1).sum(),
    )


def test_given_parameters_are_used() -> None:
    given = np.array([0.0, 1.0, 3.0, 3.5])
    np.testing.assert_array_equal(basis_of(curve(2, 5, knot_parameters=given)).break_points, given)
    with pytest.raises(ValueError, match="4 knot parameters"):
        basis_of(curve(2, 5, knot_parameters=given[:-1]))


def test_degree_one_is_the_polygon() -> None:
    one = curve(1, 6, parameterization="uniform")
    np.testing.assert_allclose(basis_of(one).evaluate(np.arange(6.0), one.values), one.values, atol=1e-12)


@pytest.mark.parametrize("repeated", [1, 2, 3])
def test_repeated_knots_equal_scipy(repeated: int) -> None:
    """What joined polynomials are made of."""
    parameters = np.array([0.0, 1.0, 2.5, 3.0])
    extended = clamped(parameters, 3, 3 - repeated)
    power, columns = bspline_power_tables(extended, 3)
    points = control_points(len(extended) - 4)
    assert len(points) == 4 + 2 * repeated and len(power) == 3
    oracle = BSpline(extended, points, 3)
    for s, (left, right) in enumerate(pairwise(parameters)):
        t = np.array([0.0, 0.2, 0.7])
        found = t[:, None] ** np.arange(4) @ (power[s] @ points[columns[s]])
        np.testing.assert_allclose(found, oracle(left + t * (right - left)), rtol=0.0, atol=1e-11)
