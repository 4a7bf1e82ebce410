"""What every registered curve family keeps: derivatives, linear maps, local support, values and coefficients."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.curves.basis import CurveBasis, harmonic_row, power_row
from splinebba_cli.core.curves.registry import FAMILIES, basis_of
from splinebba_cli.core.network import Curve, FloatArray
from tests.core.observations.random_network import NAMES, VARIANTS, curve_of

STEP = 1e-25
HARMONICS = [n for n in NAMES if FAMILIES[VARIANTS.get(n, {"family": n})["family"]].rows == "harmonics"]
every_family = pytest.mark.parametrize("name", NAMES)


def made(name: str, seed: int = 3) -> tuple[Curve, CurveBasis, FloatArray]:
    """A curve of a family, its basis and coefficients."""
    curve = curve_of(name, np.random.default_rng(seed))
    basis = basis_of(curve)
    return curve, basis, basis.coefficients_from_values(curve.values)


def places(basis: CurveBasis) -> FloatArray:
    """Locations on every segment, its ends, and beyond the ends of an open curve."""
    first, last = basis.break_points[0], basis.break_points[-1]
    inside = np.random.default_rng(1).uniform(first, last, 40)
    beyond = [] if basis.closed else [first - 0.3, last + 0.4]
    return np.concatenate([inside, basis.break_points, beyond])


def complex_points(basis: CurveBasis, coefficients: FloatArray, u: FloatArray, order: int) -> FloatArray:
    """Derivative of order `order` + 1 by a complex step in the tables, (n, 3)."""
    segment, t = basis.locate(u)
    length = np.diff(basis.break_points)[segment]
    if basis.trigonometric:
        row = harmonic_row(u + 1j * STEP, order, basis.power.shape[1])
        weights = np.einsum("nk,nkw->nw", np.imag(row) / STEP, basis.power[segment])
        return np.asarray(np.einsum("nw,nwd->nd", weights, coefficients[basis.columns[segment]]))
    weights = np.einsum("nk,nkw->nw", power_row(t + 1j * STEP, order), basis.power[segment])
    value = np.einsum("nw,nwd->nd", weights, coefficients[basis.columns[segment]])
    return np.asarray(np.imag(value) / STEP / length[:, None] ** (order + 1))


def position_shift(basis: CurveBasis, vector: FloatArray) -> FloatArray:
    """What a shift does to the values: positions move, vectors do not."""
    return np.where(basis.value_is_position[:, None], vector, 0.0)


@every_family
@pytest.mark.parametrize("order", [1, 2, 3])
def test_derivatives_equal_the_complex_step(name: str, order: int) -> None:
    _, basis, coefficients = made(name)
    u = places(basis)
    found = basis.evaluate(u, coefficients, order)
    exact = complex_points(basis, coefficients, u, order - 1)
    np.testing.assert_allclose(found, exact, rtol=0.0, atol=1e-12 * max(1.0, np.abs(exact).max()))


@every_family
def test_derivatives_equal_differences_of_the_curve(name: str) -> None:
    """Independent of the tables' own differentiation: sixth-order differences inside the segments.

    Exact for powers; of trigonometric functions the error is (k h)^6 k / 140, with h 0.03 of a quarter period of the
    highest harmonic below 1e-10.
    """
    _, basis, coefficients = made(name)
    lengths = np.diff(basis.break_points)
    u = (basis.break_points[:-1, None] + lengths[:, None] * [0.25, 0.5, 0.8]).ravel()
    h = np.repeat(0.03 * lengths, 3)
    steps, weights = (
        np.array([1, 2, 3]),
        np.array([45.0, -9.0, 1.0]) / 60.0,
    )  # exact for polynomials to degree 6
    for order in (0, 1):
        difference = sum(
            w
            * (
                basis.evaluate(u + s * h, coefficients, order)
                - basis.evaluate(u - s * h, coefficients, order)
            )
            for s, w in zip(steps, weights, strict=True)
        )
        found = basis.evaluate(u, coefficients, order + 1)
        scale = np.abs(coefficients).max() / lengths.min() ** (order + 1)
        np.testing.assert_allclose(difference / h[:, None], found, rtol=0.0, atol=1e-9 * scale)


@every_family
def test_values_and_coefficients_are_inverse_linear_maps(name: str) -> None:
    curve, basis, coefficients = made(name)
    np.testing.assert_allclose(
        basis.values_from_coefficients(coefficients), curve.values, rtol=0.0, atol=1e-12
    )
    assert basis.coefficient_count == len(coefficients) <= len(curve.values)
    if basis.coefficient_count < len(curve.values):  # tied together by continuity
        assert VARIANTS[name].get("continuity", -1) >= 0
    other = np.random.default_rng(7).normal(size=curve.values.shape)
    mixed = basis.coefficients_from_values(2.0 * curve.values - 3.0 * other)
    expected = 2.0 * coefficients - 3.0 * basis.coefficients_from_values(other)
    np.testing.assert_allclose(mixed, expected, rtol=0.0, atol=1e-11)


@every_family
def test_curves_follow_linear_maps_and_shifts(name: str) -> None:
    """X(u; A V + b) = A X(u; V) + b: what a change of the object frame does; V = vectors are not shifted."""
    curve, basis, coefficients = made(name)
    generator = np.random.default_rng(11)
    matrix, shift = generator.normal(size=(3, 3)), generator.normal(0.0, 100.0, 3)
    moved = basis.coefficients_from_values(curve.values @ matrix.T + position_shift(basis, shift))
    for order in (0, 1, 2):
        expected = basis.evaluate(places(basis), coefficients, order) @ matrix.T + (
            shift if order == 0 else 0.0
        )
        found = basis.evaluate(places(basis), moved, order)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-10 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("name", [n for n in NAMES if "bspline" not in n and n not in HARMONICS])
def test_values_that_are_positions_lie_on_the_curve(name: str) -> None:
    """Knots at the knot parameters; a line at its ends; a0 at t = 0.  Control points and centres do not."""
    curve, basis, coefficients = made(name)
    on_curve = basis.evaluate(basis.break_points, coefficients)
    positions = curve.values[basis.value_is_position]
    np.testing.assert_allclose(on_curve[: len(positions)], positions, rtol=0.0, atol=1e-11)
    if basis.closed:
        np.testing.assert_allclose(on_curve[-1], curve.values[0], rtol=0.0, atol=1e-11)


@every_family
def test_local_support(name: str) -> None:
    """A coefficient that is not under a segment does not move it, none is out of reach; at most four, or harmonics."""
    _, basis, coefficients = made(name)
    assert basis.support <= 4 or name == "fourier"
    functions = basis.coefficient_count if basis.trigonometric else 4
    assert basis.power.shape == (basis.segment_count, functions, basis.support)
    assert set(basis.columns.ravel()) == set(range(basis.coefficient_count))
    middle = 0.4 * basis.break_points[:-1] + 0.6 * basis.break_points[1:]
    before = basis.evaluate(middle, coefficients)
    for k in range(basis.coefficient_count):
        moved = coefficients.copy()
        moved[k] += 1.0
        change = np.abs(basis.evaluate(middle, moved) - before).max(axis=1)
        reached = np.array(
            [(np.abs(basis.power[s][:, basis.columns[s] == k]) > 0.0).any() for s in range(len(middle))]
        )
        assert (change[~reached] == 0.0).all() and change.max() > 0.0


@every_family
def test_anchors_are_places_of_the_curve(name: str) -> None:
    """One condition for every null at least: knots, a place for every coefficient of unjoined segments, phases."""
    _, basis, _ = made(name)
    if not basis.has_location:
        assert len(basis.anchors) == 0
        return
    assert (basis.anchors >= basis.break_points[0]).all() and (basis.anchors <= basis.break_points[-1]).all()
    knots = basis.segment_count + (not basis.closed)
    phases = max(1, basis.coefficient_count - 2)  # what m harmonics can be parametrised anew, see fourier.py
    free = (
        basis.coefficient_count if name == "unjoined" or basis.segment_count == 1 else knots
    )  # none is joined
    expected = phases if name in HARMONICS else max(free, knots)
    assert len(np.unique(basis.anchors)) == expected
    segment, _ = basis.locate(basis.anchors)
    if name not in HARMONICS:
        assert set(segment) == set(range(basis.segment_count))


@pytest.mark.parametrize("name", FAMILIES)
def test_a_family_refuses_a_wrong_number_of_rows(name: str) -> None:
    """One row more than a whole number of segments or harmonics; one less than the fewest."""
    family = FAMILIES[name]
    curve = curve_of(name, np.random.default_rng(3))
    fewest = family.fewest_open or family.fewest_closed
    few = curve.values[: fewest - 1]
    with pytest.raises(ValueError, match=f"{name}|knot" if name != "free_cubic" else name):
        basis_of(Curve("c", "tie", name, few, few))
    if family.rows == "points" and family.most is None:
        return  # any number of knots or control points
    too_many = np.vstack([curve.values, curve.values[-1:] + 1.0])
    with pytest.raises(ValueError, match=name):
        basis_of(Curve("c", "tie", name, too_many, too_many))


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(KeyError, match="spiral"):
        basis_of(Curve("c", "tie", "spiral", np.zeros((3, 3)), np.zeros((3, 3))))
