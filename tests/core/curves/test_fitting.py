"""Splines fitted to digitised points: the threshold, the number of knots, closed curves, corners, bad input."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.alignment import digitised, random_alignment
from benchmarks.smoothing_spline import smoothing_spline
from splinebba_cli.core.curves.fitting import FittedSpline, fit_spline
from splinebba_cli.core.curves.natural_cubic import natural_cubic, natural_cubic_basis
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.network import FloatArray
from splinebba_cli.errors import FitError

ORIGIN = np.array([7_600_000.0, 500_000.0, 100.0])
ROUNDING = 1e-8  # metres: a few units of the last digit of 7.6e6 (9e-10), through a curve evaluation


def ellipse(count: int = 200) -> FloatArray:
    """Points of a closed curve, 100 m × 60 m."""
    angle = 2.0 * np.pi * np.arange(count) / count
    return ORIGIN + np.stack([50.0 * np.cos(angle), 30.0 * np.sin(angle), np.sin(angle)], axis=1)


def square(per_side: int = 20) -> FloatArray:
    """Points of a square of 10 m that begin in the middle of a side."""
    corners = np.array([[5.0, 0], [10, 0], [10, 10], [0, 10], [0, 0], [5, 0]])
    sides = [np.linspace(a, b, per_side)[:-1] for a, b in pairwise(corners)]
    return np.column_stack([np.concatenate(sides), np.full(5 * (per_side - 1), 3.0)])


def independent_distances(fit: FittedSpline) -> FloatArray:
    """Distances by a global search, of the curve as a project would read it: by knots and knot parameters."""
    curve = fit.curve("c")
    basis = natural_cubic(curve)
    origin = fit.points[0]
    coefficients = basis.coefficients_from_values(curve.values - origin)
    return nearest_on_curve(basis, coefficients, fit.points - origin)[1]


@pytest.mark.parametrize("threshold", [1.0, 0.05, 0.004, 1e-4])
@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_the_threshold_is_met(threshold: float, closed: bool) -> None:
    fit = fit_spline(ellipse(), threshold, closed=closed)
    distance = independent_distances(fit)
    assert distance.max() <= threshold + ROUNDING
    # the distances that are reported are those of the nearest points
    np.testing.assert_allclose(fit.distance, distance, rtol=0.0, atol=1e-3 * threshold + ROUNDING)
    assert fit.largest_distance == fit.distance.max()
    assert fit.rms_distance == pytest.approx(np.sqrt(np.mean(fit.distance**2)))


@settings(deadline=None, max_examples=25)
@given(
    st.integers(2, 25),
    st.booleans(),
    st.sampled_from(["chord_length", "uniform"]),
    st.sampled_from([1e-7, 0.1, 3.0]),
    st.integers(0, 10**6),
)
def test_the_threshold_is_met_by_any_points(
    count: int, closed: bool, parameterization: str, threshold: float, seed: int
) -> None:
    """Even by points without any order: at the latest with a knot at every point."""
    points = np.random.default_rng(seed).normal(size=(count + closed, 3))
    fit = fit_spline(points, threshold, closed=closed, parameterization=parameterization)  # type: ignore[arg-type]
    assert fit.largest_distance <= threshold
    assert len(fit.knots) <= len(points)
    on_curve = fit.evaluate(fit.location)
    np.testing.assert_allclose(
        np.linalg.norm(on_curve - points, axis=1), fit.distance, rtol=0.0, atol=1e-9 * np.abs(points).max()
    )


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_the_curve_passes_through_its_knots(closed: bool) -> None:
    fit = fit_spline(ellipse(), 0.01, closed=closed)
    at = fit.knot_parameters[: len(fit.knots)]
    np.testing.assert_allclose(fit.evaluate(at), fit.knots, rtol=0.0, atol=ROUNDING)
    assert len(fit.knot_parameters) == len(fit.knots) + closed
    assert np.all(np.diff(fit.knot_parameters) > 0.0)


def test_a_closed_curve_is_smooth_where_it_begins() -> None:
    points = ellipse()
    fit = fit_spline(np.vstack([points, points[:1]]), 0.01, closed=True)
    assert fit.closed and fit.repeated_points == 1 and len(fit.points) == len(points)
    basis, coefficients = fit.basis, fit.basis.coefficients_from_values(fit.knots - ORIGIN)
    tiny = 1e-6 * fit.knot_parameters[-1]
    for order in (0, 1, 2):
        before, after = (basis.evaluate(np.array([u]), coefficients, order) for u in (-tiny, tiny))
        # a step of 2 tiny changes a derivative by that times the next one: 1, 1/30 m, less than 1/30² m² here
        np.testing.assert_allclose(before, after, rtol=0.0, atol=2.0 * tiny + ROUNDING)


def test_straight_points_need_two_knots() -> None:
    points = np.linspace([0.0, 0.0, 0.0], [1000.0, 50.0, 3.0], 500)
    assert len(fit_spline(points, 1e-6).knots) == 2


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_natural_spline_is_recovered_with_its_own_knots(seed: int) -> None:
    """Sampled densely at equal parameters; the threshold is a thousandth of the wave height."""
    count = 8
    generator = np.random.default_rng(seed)
    offsets = generator.normal(size=(count, 2)) * [20.0, 4.0]
    knots = np.column_stack([100.0 * np.arange(count), offsets])
    parameters = 100.0 * np.arange(count)
    basis = natural_cubic_basis(parameters)
    samples = basis.evaluate(np.linspace(0.0, parameters[-1], 481), basis.coefficients_from_values(knots))
    fit = fit_spline(samples, 0.02, parameterization="uniform")
    assert len(fit.knots) <= count
    assert independent_distances(fit).max() <= 0.02 + ROUNDING


@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_no_more_knots_than_the_smoothing_spline(noise: float) -> None:
    """Three kilometres of a railway; scipy's spline with the same largest distance is the measure."""
    points = digitised(random_alignment(3000.0, 3), 3000.0, 5.0, noise)
    fit = fit_spline(points, 0.004)
    assert independent_distances(fit).max() <= 0.004 + ROUNDING
    theirs, largest = smoothing_spline(points, 0.004, bisections=16)
    assert largest <= 0.004
    assert len(fit.knots) <= theirs


def test_the_fit_lies_between_the_points_where_the_alignment_does() -> None:
    """Points every 10 m.

    A curve that leaves the points by ± 4 mm in turn has the curvature 4 · 4 mm / (10 m)², and this the sagitta
    (10 m)² / 8 · 4 · 4 mm / (10 m)² = 2 mm between two points: so far beyond the threshold it may
    leave the alignment.
    """
    alignment = random_alignment(3000.0, 3)
    fit = fit_spline(digitised(alignment, 3000.0, 10.0, 0.0), 0.004)
    between = alignment.points(np.arange(0.0, 3000.1, 1.0))
    coefficients = fit.basis.coefficients_from_values(fit.knots)
    assert nearest_on_curve(fit.basis, coefficients, between)[1].max() <= 0.004 + 0.002


def test_long_polylines_are_searched_with_some_points_but_judged_by_all() -> None:
    points = digitised(random_alignment(6000.0, 2), 6000.0, 1.0, 0.0)
    points[3001, 1] += 0.2  # one that a thinned polyline does not have
    fit = fit_spline(points, 0.004)
    assert len(fit.points) == 6001
    assert independent_distances(fit).max() <= 0.004 + ROUNDING


def test_corners_are_knots_with_a_kink() -> None:
    points = square()[:40]  # half a side, a whole one, half of one
    fit = fit_spline(points, 0.01, corner_angle_deg=45.0)
    assert fit.breaks == (1, 2)
    np.testing.assert_allclose(fit.knots, [points[0], points[10 + 9], points[38], points[39]], atol=ROUNDING)
    assert fit_spline(points, 0.01).breaks == ()


def test_a_closed_curve_with_corners_begins_and_ends_in_one() -> None:
    fit = fit_spline(square(), 0.01, closed=True, corner_angle_deg=45.0)
    assert not fit.closed and len(fit.breaks) == 3
    np.testing.assert_array_equal(fit.knots[0], fit.knots[-1])
    np.testing.assert_allclose(fit.knots[0], [10.0, 0.0, 3.0], atol=ROUNDING)
    assert fit.largest_distance <= 0.01


def test_repeated_points_change_nothing() -> None:
    points = ellipse()[:120]
    once, thrice = fit_spline(points, 0.01), fit_spline(np.repeat(points, 3, axis=0), 0.01)
    assert (once.repeated_points, thrice.repeated_points) == (0, 240)
    np.testing.assert_array_equal(thrice.point_numbers, 3 * np.arange(120))
    # the origin that is subtracted is the rounded mean, which is the same
    np.testing.assert_array_equal(once.knots, thrice.knots)


def test_a_curve_that_crosses_itself_is_no_repetition() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    eight = np.stack([np.sin(angle), np.sin(2.0 * angle), 0.0 * angle], axis=1)
    fit = fit_spline(eight, 0.001)
    assert fit.repeated_points == 0 and fit.largest_distance <= 0.001
    assert fit.ends_meet is False  # sin(2π) is not 0 in floating point


def test_a_threshold_below_the_noise_is_told() -> None:
    points = np.column_stack([np.arange(100.0), np.random.default_rng(1).normal(size=(100, 2))])
    assert fit_spline(points, 0.01).knots_follow_noise
    assert not fit_spline(points, 5.0).knots_follow_noise


@pytest.mark.parametrize(
    ("points", "closed", "code", "words"),
    [
        (np.zeros((0, 3)), False, "SBB320", "no points"),
        (np.ones((5, 3)), False, "SBB320", "two distinct points, not 1"),
        (np.eye(3)[[0, 1, 0]], True, "SBB320", "three distinct points, not 2"),
        (np.ones((4, 2)), False, "SBB403", "rows of x, y, z"),
        ([[0, 0, 0], [1, np.nan, 1], [2, 2, np.inf]], False, "SBB403", "point 2 .* 1 more"),
    ],
)
def test_what_is_no_curve(points: FloatArray, closed: bool, code: str, words: str) -> None:
    with pytest.raises(FitError, match=words) as caught:
        fit_spline(points, closed=closed)
    assert caught.value.code == code


@pytest.mark.parametrize(
    "options", [{"threshold_m": 0.0}, {"threshold_m": np.nan}, {"corner_angle_deg": 200.0}]
)
def test_bad_options(options: dict[str, float]) -> None:
    with pytest.raises(FitError) as caught:
        fit_spline(ellipse(), **options)  # type: ignore[arg-type]
    assert caught.value.code == "SBB900"
