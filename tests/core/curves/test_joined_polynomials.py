"""Polynomials of several segments: parameters that continuity leaves, exact joints, values by least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray

UNEVEN = np.array([0.0, 1.0, 1.5, 4.0, 4.2, 6.0])


def curve(segments: int, degree: int = 3, **options: object) -> Curve:
    rows = np.random.default_rng(segments).normal(0.0, 10.0, (segments * (degree + 1), 3))
    made = Curve("c", "tie", f"polynomial_{degree}", rows, np.full_like(rows, np.inf))
    return replace(made, **options)  # type: ignore[arg-type]


def sides(basis: CurveBasis, coefficients: FloatArray, order: int) -> tuple[FloatArray, FloatArray]:
    """Derivative d/du of an order at all inner joints, from the segments before and after."""
    a = basis.power @ coefficients[basis.columns]
    length = np.diff(basis.break_points)[:, None]
    powers = np.arange(4)
    factor = np.prod([np.maximum(powers - i, 0) for i in range(order)], axis=0) if order else np.ones(4)
    end, start = np.einsum("k,skd->sd", factor, a), factor[order] * a[:, order]
    return (end / length**order)[:-1], (start / length**order)[1:]


@pytest.mark.parametrize("segments", [1, 2, 3, 4, 7])
def test_parameters_that_are_left(segments: int) -> None:
    """4n, 3n + 1, 2n + 2, n + 3 and n + 1; 3n, 2n + 1, n + 2 of parabolas; 2n, n + 1 of lines."""
    n = segments
    cubic = {c: basis_of(curve(n, continuity=c)).coefficient_count for c in (-1, 0, 1, 2)}
    assert cubic == {-1: 4 * n, 0: 3 * n + 1, 1: 2 * n + 2, 2: n + 3}
    assert basis_of(curve(n, continuity=2, natural_ends=True)).coefficient_count == n + 1
    parabola = {c: basis_of(curve(n, 2, continuity=c)).coefficient_count for c in (-1, 0, 1)}
    assert parabola == {-1: 3 * n, 0: 2 * n + 1, 1: n + 2}
    line = {c: basis_of(curve(n, 1, continuity=c)).coefficient_count for c in (-1, 0)}
    assert line == {-1: 2 * n, 0: n + 1}


@pytest.mark.parametrize("parameters", [None, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize(
    ("degree", "continuity", "natural"),
    [(1, 0, False), (2, 0, False), (2, 1, False), (3, 0, False), (3, 1, False), (3, 2, False), (3, 2, True)],
)
def test_joints_are_exact(degree: int, continuity: int, natural: bool, parameters: FloatArray | None) -> None:
    """Any coefficients at all: derivatives over u agree up to the continuity, and not beyond it."""
    one = curve(5, degree, continuity=continuity, natural_ends=natural, knot_parameters=parameters)
    basis = basis_of(one)
    coefficients = np.random.default_rng(9).normal(0.0, 10.0, (basis.coefficient_count, 3))
    for order in range(continuity + 1):
        before, after = sides(basis, coefficients, order)
        np.testing.assert_allclose(before, after, rtol=0.0, atol=1e-10 * np.abs(before).max())
    before, after = sides(basis, coefficients, continuity + 1)
    assert np.abs(before - after).max() > 0.1
    ends = basis.evaluate(basis.break_points[[0, -1]], coefficients, 2)
    assert (np.abs(ends).max() < 1e-9) == (natural or degree == 1)


def test_natural_ends_make_a_natural_spline() -> None:
    one = curve(5, continuity=2, natural_ends=True, knot_parameters=UNEVEN)
    basis, natural = basis_of(one), natural_cubic_basis(UNEVEN)
    knots = np.random.default_rng(5).normal(0.0, 10.0, (6, 3))
    values = basis.values_from_coefficients(natural.coefficients_from_values(knots))
    np.testing.assert_allclose(values[::4], knots[:-1], atol=1e-12)
    u = np.linspace(0.0, 6.0, 50)
    found = basis.evaluate(u, basis.coefficients_from_values(values))
    np.testing.assert_allclose(
        found, natural.evaluate(u, natural.coefficients_from_values(knots)), atol=1e-10
    )


def test_unjoined_values_are_the_coefficients() -> None:
    one = curve(3)
    np.testing.assert_array_equal(basis_of(one).coefficients_from_values(one.values), one.values)
    jump = sides(basis_of(one), one.values, 0)
    assert np.abs(jump[0] - jump[1]).min() > 0.01


@pytest.mark.parametrize("segments", [4, 30])
def test_values_beyond_the_continuity_are_fitted_by_least_squares(segments: int) -> None:
    """Dense for 16 rows, sparse for 120: the residuals are normal to what the coefficients reach."""
    one = curve(segments, continuity=1)
    basis = basis_of(one)
    residual = basis.values_from_coefficients(basis.coefficients_from_values(one.values)) - one.values
    assert np.abs(residual).max() > 1.0
    reached = np.zeros((basis.coefficient_count, 3))
    np.add.at(reached, basis.value_columns, basis.value_weights[:, :, None] * residual[:, None, :])
    assert np.abs(reached).max() < 1e-9


def test_starting_points_are_coefficients_of_joined_segments() -> None:
    """Lee's start point can be held: a_0 of the first segment is one coefficient, with C0 a_0 of every segment."""
    for continuity, pure in ((0, [0, 4, 8]), (1, [0]), (2, [0])):
        rows, _, factor = basis_of(curve(3, continuity=continuity)).pure_values()
        assert rows.tolist() == pure and (factor == 1.0).all()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"continuity": 3}, "cannot be joined C3"),
        ({"continuity": 1, "natural_ends": True}, "natural ends"),
        ({"knot_parameters": np.array([0.0, 1.0])}, "4 knot parameters"),
    ],
)
def test_what_is_no_curve_is_refused(options: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        basis_of(curve(3, **options))
    with pytest.raises(ValueError, match="natural ends"):
        basis_of(curve(3, 2, continuity=1, natural_ends=True))
    with pytest.raises(ValueError, match="C1"):
        basis_of(curve(3, 1, continuity=1))
