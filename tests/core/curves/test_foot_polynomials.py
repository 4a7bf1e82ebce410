"""The polynomials of degree 5 and 7 are what they are said to be: half the derivative of the squared distance."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.bernstein import from_powers, value_and_slope
from splinebba_cli.core.curves.foot_polynomials import (
    PhotoStationarity,
    foot_on_line_in_photo,
    foot_on_line_in_space,
    stationary_in_space,
    velocity_numerators,
)
from splinebba_cli.core.network import FloatArray

STEP = 1e-30


def powers(a: FloatArray, t: complex) -> np.ndarray:
    return sum(a[k] * t**k for k in range(len(a)))


def test_in_space_it_is_the_derivative_of_the_squared_distance() -> None:
    a = np.random.default_rng(1).normal(size=(4, 2, 50))
    b = stationary_in_space(from_powers(a))
    assert b.shape == (6, 50)
    for t in np.linspace(-1.0, 2.0, 9):  # more places than a polynomial of degree 5 can agree at by chance
        square = np.sum(powers(a, t + 1j * STEP) ** 2, axis=0)
        value, _ = value_and_slope(b, np.full(50, t))
        np.testing.assert_allclose(value, 0.5 * square.imag / STEP, rtol=1e-9, atol=1e-9)


def test_in_the_photo_it_is_the_derivative_times_the_third_power_of_the_depth() -> None:
    g = np.random.default_rng(2)
    q, depth, measured = g.normal(size=(4, 2, 50)), g.normal(size=(4, 50)), g.normal(size=(2, 50))
    depth[0] += 8.0
    b = PhotoStationarity.of(from_powers(q), from_powers(depth)).at(np.arange(50), measured)
    assert b.shape == (8, 50)
    for t in np.linspace(-1.0, 2.0, 12):
        at = t + 1j * STEP
        square = np.sum((powers(q, at) / powers(depth, at) - measured) ** 2, axis=0)
        value, _ = value_and_slope(b, np.full(50, t))
        expected = 0.5 * square.imag / STEP * powers(depth, t).real ** 3
        np.testing.assert_allclose(value, expected, rtol=1e-9, atol=1e-8)


def test_points_take_their_own_segments() -> None:
    g = np.random.default_rng(3)
    q, depth = g.normal(size=(4, 2, 3)), g.uniform(5.0, 6.0, (4, 3))
    column, measured = np.array([2, 0, 2, 1]), g.normal(size=(2, 4))
    together = PhotoStationarity.of(q, depth).at(column, measured)
    for k, own in enumerate(column):
        alone = PhotoStationarity.of(q[:, :, [own]], depth[:, [own]]).at(np.array([0]), measured[:, [k]])
        np.testing.assert_array_equal(together[:, [k]], alone)


def test_the_velocity_numerator_has_degree_4() -> None:
    g = np.random.default_rng(4)
    q, depth = g.normal(size=(4, 2, 30)), g.normal(size=(4, 30))
    e = velocity_numerators(from_powers(q), from_powers(depth))
    for t in (-0.7, 0.0, 0.3, 1.0, 1.8, 2.5):
        at = np.full(30, t)
        (x, x1), (d, d1) = value_and_slope(from_powers(q), at), value_and_slope(from_powers(depth), at)
        np.testing.assert_allclose(value_and_slope(e, at)[0], x1 * d - x * d1, rtol=1e-9, atol=1e-9)


def test_lines_in_closed_form() -> None:
    g = np.random.default_rng(5)
    start, along, depth = g.normal(size=(2, 40)), g.normal(size=(2, 40)), g.uniform(4.0, 5.0, (2, 40))
    depth[1] -= 4.5
    t = foot_on_line_in_photo(start, along, depth)
    for other in (t + 1e-4, t - 1e-4, t + 1.0):
        there, here = (
            np.abs(np.linalg.norm(start + at * along, axis=0) / (depth[0] + at * depth[1]))
            for at in (other, t)
        )
        assert (there > here).all()
    t = foot_on_line_in_space(start, along)
    np.testing.assert_allclose(np.sum((start + t * along) * along, axis=0), 0.0, atol=1e-12)
    assert np.isnan(foot_on_line_in_space(start, 0.0 * along)).all()
