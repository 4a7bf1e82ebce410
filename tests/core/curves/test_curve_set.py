"""All curves evaluated together equal the single bases; nearest points of a curve in object space."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import FloatArray
from tests.core.observations.random_network import NAMES as ALL_NAMES
from tests.core.observations.random_network import curve_of

NAMES = [*ALL_NAMES, "natural_cubic", "closed"]


@cache
def all_curves() -> tuple[CurveSet, FloatArray]:
    """One curve of every family and more, with coefficients."""
    generator = np.random.default_rng(6)
    curves = [curve_of(name, generator) for name in NAMES]
    bases = [basis_of(curve) for curve in curves]
    coefficients = [b.coefficients_from_values(c.values) for b, c in zip(bases, curves, strict=True)]
    return CurveSet.of(bases), np.vstack(coefficients)


def places(number: int) -> FloatArray:
    """Locations inside, at the knots and outside of a curve, several turns of a closed one."""
    basis = all_curves()[0].bases[number]
    first, last = basis.break_points[0], basis.break_points[-1]
    inside = np.random.default_rng(number).uniform(first, last, 30)
    beyond = [first - 0.4, last + 0.3]
    if basis.closed:
        beyond += [first - 2.2 * (last - first), last + 1.7 * (last - first)]
    return np.concatenate([inside, basis.break_points, beyond])


def test_counts() -> None:
    curves, coefficients = all_curves()
    assert curves.coefficient_count == len(coefficients) == sum(b.coefficient_count for b in curves.bases)
    assert curves.support == max(b.support for b in curves.bases)
    np.testing.assert_array_equal(np.diff(curves.segment_start), [b.segment_count for b in curves.bases])
    np.testing.assert_array_equal(curves.closed, [b.closed for b in curves.bases])
    np.testing.assert_array_equal(curves.has_location, [b.has_location for b in curves.bases])


@pytest.mark.parametrize("number", range(len(NAMES)), ids=[f"{k}-{name}" for k, name in enumerate(NAMES)])
def test_evaluation_equals_the_single_basis(number: int) -> None:
    """Values and derivatives, on the same segment."""
    curves, coefficients = all_curves()
    basis, u = curves.bases[number], places(number)
    own = coefficients[curves.coefficient_start[number] : curves.coefficient_start[number + 1]]
    curve = np.full(len(u), number)
    for order, found in enumerate(curves.evaluate(coefficients, curve, u, (0, 1, 2, 3))):
        expected = basis.evaluate(u, own, order)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * max(1.0, np.abs(expected).max()))
    segment, t = curves.locate(curve, u)
    inner = (np.abs(basis.locate(u)[1] - 0.5) < 0.499) | (basis.segment_count == 1)
    np.testing.assert_array_equal((segment - curves.segment_start[number])[inner], basis.locate(u)[0][inner])
    np.testing.assert_allclose(t[inner], basis.locate(u)[1][inner], rtol=0.0, atol=1e-9)


def test_curves_do_not_mix() -> None:
    """Locations of all curves in one call, in any order."""
    curves, coefficients = all_curves()
    curve = np.concatenate([np.full(len(places(k)), k) for k in range(len(NAMES))])
    u = np.concatenate([places(k) for k in range(len(NAMES))])
    order = np.random.default_rng(0).permutation(len(u))
    whole = curves.evaluate(coefficients, curve[order], u[order])[0]
    single = np.vstack([curves.evaluate(coefficients, curve[k : k + 1], u[k : k + 1])[0] for k in order])
    np.testing.assert_allclose(whole, single, rtol=0.0, atol=1e-12)


def test_closed_curves_wrap_into_their_domain_and_open_ones_stay() -> None:
    curves, _ = all_curves()
    for number, basis in enumerate(curves.bases):
        u = places(number)
        wrapped = curves.wrap(np.full(len(u), number), u)
        if basis.closed:
            assert (wrapped >= basis.break_points[0]).all() and (
                wrapped < basis.break_points[-1] + 1e-9
            ).all()
            turns = (u - wrapped) / (basis.break_points[-1] - basis.break_points[0])
            np.testing.assert_allclose(turns, np.round(turns), rtol=0.0, atol=1e-9)
        else:
            np.testing.assert_array_equal(wrapped, u)


def test_power_form_of_the_segments() -> None:
    curves, coefficients = all_curves()
    a = curves.segment_polynomials(coefficients)
    t = np.array([0.0, 0.3, 1.0])
    for segment in np.flatnonzero(~curves.trigonometric):
        curve = int(np.searchsorted(curves.segment_start, segment, side="right") - 1)
        u = curves.left[segment] + np.array([1e-9, 0.3, 1.0 - 1e-9]) * curves.length[segment]
        expected = curves.evaluate(coefficients, np.full(3, curve), u)[0]
        assert (a[segment, 4:] == 0.0).all()
        found = t[:, None] ** np.arange(4) @ a[segment, :4]
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6)


def test_derivatives_by_horner_equal_the_evaluation() -> None:
    """The path of the foot points, all families together and splines alone."""
    curves, coefficients = all_curves()
    polynomials = [k for k, basis in enumerate(curves.bases) if not basis.trigonometric]
    rows = np.concatenate([np.arange(*curves.coefficient_start[k : k + 2]) for k in polynomials])
    alone = CurveSet.of([curves.bases[k] for k in polynomials])
    assert curves.any_trigonometric and not alone.any_trigonometric and alone.power.shape[1:] == (4, 4)
    for every, own in ((curves, coefficients), (alone, coefficients[rows])):
        u = np.concatenate(
            [np.random.default_rng(4).uniform(b.break_points[0], b.break_points[-1], 30) for b in every.bases]
        )
        curve = np.repeat(np.arange(len(every.bases)), 30)
        found = every.derivatives(every.segment_polynomials(own), *every.locate(curve, u))
        for order, expected in enumerate(every.evaluate(own, curve, u, (0, 1, 2))):
            np.testing.assert_allclose(found[order], expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


def test_no_curves() -> None:
    empty = CurveSet.of([])
    assert empty.coefficient_count == 0 and len(empty.left) == 0


@pytest.mark.parametrize(
    "name",
    ["natural_cubic", "closed", "corner", "straight_line", "free_cubic", "fourier", "conic", "arc", "tense"],
)
def test_nearest_point_in_object_space(name: str) -> None:
    """Not farther than any of 20 001 samples; normal to the curve for points some metres beside it."""
    generator = np.random.default_rng(9)
    curve = curve_of(name, generator)
    basis = basis_of(curve)
    coefficients = basis.coefficients_from_values(curve.values)
    middle = generator.uniform(basis.break_points[0], basis.break_points[-1], 40)
    beside = basis.evaluate(middle, coefficients) + generator.normal(0.0, 2.0, (40, 3))
    points = np.vstack([beside, generator.normal(0.0, 40.0, (40, 3))])
    u, distance = nearest_on_curve(basis, coefficients, points)
    samples = basis.evaluate(np.linspace(basis.break_points[0], basis.break_points[-1], 20_001), coefficients)
    dense = np.array([np.min(np.linalg.norm(samples - point, axis=1)) for point in points])
    assert (distance <= dense * (1.0 + 1e-9)).all()
    difference = basis.evaluate(u, coefficients) - points
    np.testing.assert_allclose(np.linalg.norm(difference, axis=1), distance)
    tangent = basis.evaluate(u, coefficients, 1)
    cosine = (
        np.sum(difference * tangent, axis=1)
        / np.linalg.norm(difference, axis=1)
        / np.linalg.norm(tangent, axis=1)
    )
    inside = (np.arange(len(u)) < len(beside)) & (u > basis.break_points[0]) & (u < basis.break_points[-1])
    if name == "corner":
        inside &= np.abs(u[:, None] - basis.break_points).min(axis=1) > 1e-3
    assert inside.sum() > 10 and np.abs(cosine[inside]).max() < 1e-6
