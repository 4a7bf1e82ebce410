"""Confidence factors, circles and ellipses: known values, quadrature by another rule, and drawn positions.

Monte Carlo: N = 200 000 draws; the share inside is binomial, checked at 99 % (2.576 standard deviations).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate, stats

from splinebba_cli.core.quality.confidence import (
    circular_probability,
    circular_radius,
    confidence_factor,
)
from splinebba_cli.core.quality.high_correlations import correlations
from splinebba_cli.core.quality.position_precision import error_ellipses, horizontal_ellipses

DRAWS = 200_000
C = np.array([[4.0, 1.2, 0.3], [1.2, 1.0, -0.2], [0.3, -0.2, 0.5]])


@pytest.mark.parametrize("degrees", [None, 1.0, 5.0, 772.0])
def test_factors_are_quantiles(degrees: float | None) -> None:
    for k in (1, 2, 3):
        square = confidence_factor(k, 0.95, degrees) ** 2
        mass = stats.chi2.cdf(square, k) if degrees is None else stats.f.cdf(square / k, k, degrees)
        assert mass == pytest.approx(0.95, abs=1e-9)
    assert confidence_factor(2, 0.95, None) == pytest.approx(2.4477, abs=1e-4)  # the usual table


@pytest.mark.parametrize("confidence", [0.39, 0.5, 0.95, 0.999])
@pytest.mark.parametrize("ratio", [0.0, 1e-4, 0.03, 0.3, 0.9, 1.0])
def test_circle_against_quadrature_over_one_coordinate(ratio: float, confidence: float) -> None:
    """P = int phi(z) (2 Phi(sqrt(R^2 - b^2 z^2) / a) - 1) dz, by adaptive quadrature to 1e-10."""
    (radius,) = circular_radius(np.array([[1.0, ratio]]), confidence, None)
    edge = min(radius / max(ratio, 1e-300), 9.0)

    def slice_of(z: float) -> float:
        return stats.norm.pdf(z) * (
            2.0 * stats.norm.cdf(np.sqrt(max(radius**2 - (ratio * z) ** 2, 0.0))) - 1.0
        )

    mass = integrate.quad(slice_of, -edge, edge, epsabs=1e-11, limit=200)[0]
    assert mass == pytest.approx(confidence, abs=1e-8)


def test_circle_between_its_limits() -> None:
    one, two = (confidence_factor(k, 0.95, 7.0) for k in (1, 2))
    found = circular_radius(np.array([[3.0, 0.0], [3.0, 3.0], [0.0, 0.0]]), 0.95, 7.0)
    assert found == pytest.approx([3.0 * one, 3.0 * two, 0.0], rel=1e-8)
    assert circular_probability(found[:2], np.array([[3.0, 0.0], [3.0, 3.0]]), 7.0) == pytest.approx(
        [0.95, 0.95], abs=1e-9
    )


@pytest.mark.parametrize("degrees", [None, 4.0])
def test_drawn_positions_fall_inside(degrees: float | None) -> None:
    rng = np.random.default_rng(5)
    x = rng.multivariate_normal(np.zeros(3), C, DRAWS)
    if degrees is not None:  # divided by an estimated standard deviation of unit weight
        x /= np.sqrt(rng.chisquare(degrees, DRAWS) / degrees)[:, None]
    found = error_ellipses(("p",), C[None], 0.9, degrees)
    along = np.array([np.sin(found.azimuth_rad[0]), np.cos(found.azimuth_rad[0])])
    across = np.array([along[1], -along[0]])
    ellipse = confidence_factor(2, 0.9, degrees)
    ellipsoid = confidence_factor(3, 0.9, degrees)
    inside = {
        "circle": np.hypot(x[:, 0], x[:, 1]) < found.horizontal_m[0],
        "vertical": np.abs(x[:, 2]) < found.vertical_m[0],
        "ellipse": np.hypot(
            x[:, :2] @ along / found.semi_axes_m[0, 0], x[:, :2] @ across / found.semi_axes_m[0, 1]
        )
        < ellipse,
        "ellipsoid": np.linalg.norm(x @ found.ellipsoid_axes[0].T / found.ellipsoid_m[0], axis=1) < ellipsoid,
    }
    for name, each in inside.items():
        assert abs(each.mean() - 0.9) < 2.576 * np.sqrt(0.9 * 0.1 / DRAWS), name


def test_ellipse_of_a_known_direction() -> None:
    """3 by 1, its larger axis at azimuth 30 degrees (from Y towards X)."""
    axis = np.array([np.sin(np.radians(30.0)), np.cos(np.radians(30.0))])
    dispersion = 9.0 * np.outer(axis, axis) + np.outer([axis[1], -axis[0]], [axis[1], -axis[0]])
    semi_axes, azimuth = horizontal_ellipses(np.stack([dispersion, np.diag([1.0, 4.0]), np.zeros((2, 2))]))
    assert semi_axes == pytest.approx(np.array([[3.0, 1.0], [2.0, 1.0], [0.0, 0.0]]), abs=1e-12)
    assert np.degrees(azimuth[0]) == pytest.approx(30.0)
    assert np.sin(azimuth[1]) == pytest.approx(0.0, abs=1e-12)


def test_a_thin_ellipse_keeps_its_smaller_axis() -> None:
    """1 m by 1 µm turned by 45 degrees: the difference of the halves would leave rounding of 1e-16 m² (10 nm)."""
    spread = np.array([[0.5 + 0.5e-12, 0.5 - 0.5e-12], [0.5 - 0.5e-12, 0.5 + 0.5e-12]])
    semi_axes, _ = horizontal_ellipses(spread[None])
    assert semi_axes[0, 1] == pytest.approx(1e-6, rel=1e-3)


def test_correlations_of_held_unknowns_are_none() -> None:
    r = correlations(np.array([[4.0, 0.0, 1.9], [0.0, 0.0, 0.0], [1.9, 0.0, 1.0]]))
    assert r == pytest.approx(np.array([[1.0, 0.0, 0.95], [0.0, 0.0, 0.0], [0.95, 0.0, 1.0]]))


@pytest.mark.parametrize("degrees", [None, 7.0])
def test_many_ellipses_come_from_a_table_that_agrees_with_single_ones(degrees: float | None) -> None:
    """The spline between 1 001 ratios is within 3e-9 of the solution."""
    axes = np.random.default_rng(8).uniform(0.0, 1.0, (3000, 2))
    found = circular_radius(axes, 0.95, degrees)
    single = np.concatenate([circular_radius(part, 0.95, degrees) for part in np.split(axes, 10)])
    np.testing.assert_allclose(found, single, rtol=5e-9, atol=0.0)
