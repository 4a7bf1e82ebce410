"""Nearest points of a curve, against a dense sampling."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.nearest import nearest_on_curve


def test_a_short_segment_does_not_hold_up_the_search_in_a_long_one() -> None:
    """A segment of 1 m beside segments of 500 m."""
    parameters = np.array([0.0, 500.0, 501.0, 1000.0, 1500.0])
    basis = natural_cubic_basis(parameters)
    knots = np.stack([parameters, [0.0, 40.0, 40.1, -10.0, 5.0], np.zeros(5)], axis=1)
    coefficients = basis.coefficients_from_values(knots)
    at = np.linspace(1.0, 1499.0, 97)
    tangent = basis.evaluate(at, coefficients, 1)
    normal = np.stack([-tangent[:, 1], tangent[:, 0], np.zeros(len(at))], axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    u, distance = nearest_on_curve(basis, coefficients, basis.evaluate(at, coefficients) + 0.5 * normal)
    # radii of curvature are larger than 0.5 m: the foot of the normal is the nearest point
    np.testing.assert_allclose(distance, 0.5, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(u, at, rtol=0.0, atol=1e-6)
