"""Natural cubic splines against scipy, and the coefficients that Lee's tables recover."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.curves.natural_cubic import natural_cubic, natural_cubic_basis
from splinebba_cli.core.network import Curve, FloatArray

LEE_KNOTS = np.array([[3232.0, 4261.0, 18.0], [3335.0, 4343.0, 52.0], [3373.0, 4387.0, 34.0]])
Parameters = Literal["uniform", "chord_length"]


def winding(count: int, seed: int = 0) -> FloatArray:
    """Knots along a random walk, distances between 1 and 20 m."""
    generator = np.random.default_rng(seed + count)
    steps = generator.normal(size=(count, 3))
    steps *= generator.uniform(1.0, 20.0, (count, 1)) / np.linalg.norm(steps, axis=1)[:, None]
    return np.cumsum(steps, axis=0)


def curve(knots: FloatArray, closed: bool = False, parameters: Parameters = "chord_length") -> Curve:
    return Curve("c", "tie", "natural_cubic", knots, np.full_like(knots, np.inf), closed, None, parameters)


def lee_coefficients(basis: CurveBasis, knots: FloatArray) -> FloatArray:
    """a0..a3 of every segment for t in [0, 1], (S, 4, 3)."""
    return basis.power @ basis.coefficients_from_values(knots)[basis.columns]


def scipy_coefficients(basis: CurveBasis, knots: FloatArray, closed: bool) -> FloatArray:
    """The same from scipy, whose segments run over the knot distance."""
    parameters = basis.break_points
    if closed:
        knots = np.vstack([knots, knots[:1]])
    spline = CubicSpline(parameters, knots, bc_type="periodic" if closed else "natural")
    length = np.diff(parameters)
    return np.moveaxis(spline.c[::-1], 0, 1) * length[:, None, None] ** np.arange(4)[:, None]


def test_the_coefficients_of_lee() -> None:
    """Second segment of the spline of table 5.4 (theory, section 2)."""
    basis = natural_cubic(curve(LEE_KNOTS, parameters="uniform"))
    second = lee_coefficients(basis, LEE_KNOTS)[1]
    expected = [[3335.0, 70.5, -48.75, 16.25], [4343.0, 63.0, -28.5, 9.5], [52.0, 8.0, -39.0, 13.0]]
    np.testing.assert_allclose(second.T, expected, rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("parameters", ["uniform", "chord_length"])
@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 7, 12, 64, 65, 200])
def test_coefficients_equal_scipy(count: int, closed: bool, parameters: Parameters) -> None:
    """From one segment to more knots than the dense solution takes."""
    if closed and count < 3:
        pytest.skip("a closed spline needs three knots")
    knots = winding(count)
    basis = natural_cubic(curve(knots, closed, parameters))
    expected = scipy_coefficients(basis, knots, closed)
    np.testing.assert_allclose(
        lee_coefficients(basis, knots), expected, rtol=0.0, atol=1e-9 * np.abs(expected).max()
    )


def test_given_parameters_are_used() -> None:
    knots, given = winding(6), np.array([0.0, 1.0, 1.5, 4.0, 4.2, 9.0])
    basis = natural_cubic(replace(curve(knots), knot_parameters=given))
    np.testing.assert_array_equal(basis.break_points, given)
    np.testing.assert_allclose(
        lee_coefficients(basis, knots), scipy_coefficients(basis, knots, False), atol=1e-9
    )


def test_parameters_of_knots() -> None:
    knots = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [3.0, 4.0, 12.0], [3.0, 0.0, 12.0]])
    np.testing.assert_array_equal(knot_parameters(knots, "uniform", False), [0, 1, 2, 3])
    np.testing.assert_array_equal(knot_parameters(knots, "uniform", True), [0, 1, 2, 3, 4])
    np.testing.assert_allclose(knot_parameters(knots, "chord_length", False), [0, 5, 17, 21])
    back = float(np.linalg.norm(knots[-1] - knots[0]))
    np.testing.assert_allclose(knot_parameters(knots, "chord_length", True), [0, 5, 17, 21, 21 + back])


@pytest.mark.parametrize("count", [3, 4, 5, 9])
def test_smoothness_and_natural_ends(count: int) -> None:
    """C2 at inner knots; no curvature at the ends of an open spline; closed ones are smooth everywhere."""
    knots = winding(count, 5)
    for closed in (False, True):
        basis = natural_cubic(curve(knots, closed))
        a, length = lee_coefficients(basis, knots), np.diff(basis.break_points)
        for order, factors in enumerate(([1, 1, 1, 1], [0, 1, 2, 3], [0, 0, 2, 6])):
            end = np.einsum("k,skd->sd", factors, a) / length[:, None] ** order
            start = a[:, order] * max(1, order) / length[:, None] ** order
            right = np.roll(start, -1, axis=0) if closed else start[1:]
            left = end if closed else end[:-1]
            np.testing.assert_allclose(left, right, rtol=0.0, atol=1e-9 * np.abs(knots).max())
        if not closed:
            second = basis.evaluate(basis.break_points[[0, -1]], basis.coefficients_from_values(knots), 2)
            assert np.abs(second).max() < 1e-9


def test_one_segment_is_a_straight_line_and_ends_are_coefficients() -> None:
    knots = winding(2)
    basis = natural_cubic(curve(knots))
    a = lee_coefficients(basis, knots)[0]
    np.testing.assert_allclose(a, [knots[0], knots[1] - knots[0], np.zeros(3), np.zeros(3)], atol=1e-12)
    for count in (2, 5, 9):
        knots = winding(count)
        coefficients = natural_cubic(curve(knots)).coefficients_from_values(knots)
        np.testing.assert_allclose(coefficients[[0, -1]], knots[[0, -1]], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("breaks", [(1,), (4,), (2, 3), (1, 5, 7), (1, 2, 3, 4, 5, 6, 7)])
def test_corners_join_natural_splines(breaks: tuple[int, ...]) -> None:
    """Every piece between corners is the natural spline of its own knots; the next piece starts where it ends."""
    knots = winding(9, 2)
    basis = natural_cubic(replace(curve(knots), breaks=breaks))
    a, parameters = lee_coefficients(basis, knots), basis.break_points
    ends = [0, *breaks, len(knots) - 1]
    for start, stop in pairwise(ends):
        piece = natural_cubic_basis(parameters[start : stop + 1])
        expected = scipy_coefficients(piece, knots[start : stop + 1], False)
        np.testing.assert_allclose(a[start:stop], expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


def test_closed_curves_wrap_and_open_ones_extend() -> None:
    knots = winding(6, 3)
    basis = natural_cubic(curve(knots, closed=True))
    coefficients, u = basis.coefficients_from_values(knots), np.linspace(0.0, basis.break_points[-1], 17)[:-1]
    for turns in (-2.0, 1.0):
        far = basis.evaluate(u + turns * basis.break_points[-1], coefficients)
        np.testing.assert_allclose(far, basis.evaluate(u, coefficients), rtol=0.0, atol=1e-9)
    basis = natural_cubic(curve(knots))
    coefficients = basis.coefficients_from_values(knots)
    last, end = lee_coefficients(basis, knots)[-1], basis.break_points
    t = 1.0 + 2.0 / (end[-1] - end[-2])
    beyond = basis.evaluate(end[-1:] + 2.0, coefficients)[0]
    np.testing.assert_allclose(beyond, t ** np.arange(4) @ last, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("place", [0, 3, 4])
def test_coinciding_knots_are_refused(place: int) -> None:
    knots = winding(6)
    knots[place + 1] = knots[place]
    with pytest.raises(ValueError, match="coincide"):
        natural_cubic(curve(knots))
    natural_cubic(curve(knots, parameters="uniform"))  # a cusp, but a curve


def test_what_is_no_curve_is_refused() -> None:
    knots = winding(5)
    with pytest.raises(ValueError, match="coincide"):
        natural_cubic(curve(np.vstack([knots, knots[:1]]), closed=True))  # first knot repeated at the end
    with pytest.raises(ValueError, match="three knots"):
        natural_cubic(curve(knots[:2], closed=True))
    with pytest.raises(ValueError, match="5 knot parameters"):
        natural_cubic(replace(curve(knots), knot_parameters=np.arange(4.0)))
    with pytest.raises(ValueError, match="ascend"):
        natural_cubic(replace(curve(knots), knot_parameters=np.array([0.0, 2.0, 1.0, 3.0, 4.0])))
    for breaks in ((0,), (4,), (2, 2)):
        with pytest.raises(ValueError, match="corners"):
            natural_cubic(replace(curve(knots), breaks=breaks))
    with pytest.raises(ValueError, match="corners in a closed spline"):
        natural_cubic(replace(curve(knots, closed=True), breaks=(2,)))


def test_a_single_knot_is_no_spline() -> None:
    with pytest.raises(ValueError, match="knot"):
        natural_cubic(curve(winding(1)))
