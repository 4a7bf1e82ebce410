"""Integrals along curves: exact for what the rules promise, split at joints, around closed curves."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.curves.arc_length import quadrature_nodes
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.polynomial import polynomial_basis
from splinebba_cli.core.network import FloatArray

PARAMETERS = np.array([0.0, 1.0, 2.5, 3.0, 5.0])


def curves() -> CurveSet:
    return CurveSet.of(
        [
            polynomial_basis(3, np.array([0.0, 1.0])),
            natural_cubic_basis(PARAMETERS),
            natural_cubic_basis(PARAMETERS, closed=True),
        ]
    )


def integral(curve: int, low: float, high: float, simpson: bool, f) -> float:  # type: ignore[no-untyped-def]
    made = curves()
    nodes = quadrature_nodes(made, np.array([curve]), np.array([low]), np.array([high]), np.array([simpson]))
    u = made.left[nodes.segment] + nodes.t * made.length[nodes.segment]
    return float(nodes.weight @ f(u))


def test_gauss_legendre_is_exact_for_pieces_of_degree_15() -> None:
    def f(u: FloatArray) -> FloatArray:
        return np.where(u < 1.0, 1.0, np.where(u < 2.5, u**15, -u))

    exact = 0.6 + (2.5**16 - 1.0) / 16 - (2.9**2 - 2.5**2) / 2
    assert integral(1, 0.4, 2.9, False, f) == pytest.approx(exact, rel=1e-14)


def test_simpson_is_one_step() -> None:
    assert integral(1, 0.4, 2.9, True, lambda u: u**3) == pytest.approx((2.9**4 - 0.4**4) / 4, rel=1e-14)
    assert integral(1, 0.0, 1.0, True, lambda u: u**4) == pytest.approx((1 / 6) * (4 / 16 + 1), rel=1e-14)


def test_around_a_closed_curve() -> None:
    """From 4 over the start of the domain to 1.5 = 6.5 - 5: the function of the wrapped location."""

    def f(u: FloatArray) -> FloatArray:
        return u**2

    exact = (5.0**3 - 4.0**3) / 3 + 1.5**3 / 3
    assert integral(2, 4.0, 6.5, False, f) == pytest.approx(exact, rel=1e-14)
    assert integral(2, 0.7, 5.7, False, f) == pytest.approx(5.0**3 / 3, rel=1e-14)


def test_beyond_the_ends_of_an_open_curve() -> None:
    assert integral(1, -0.3, 0.2, False, lambda u: 1.0 + 0.0 * u) == pytest.approx(0.5, rel=1e-14)


def test_derivatives_over_the_ends() -> None:
    """Those of the sum itself, by differences of an integrand that the rules integrate exactly."""
    made, low, high, h = curves(), np.array([0.4, 0.4]), np.array([2.9, 2.9]), 1e-5
    curve, simpson = np.array([1, 1]), np.array([False, True])

    def total(low: FloatArray, high: FloatArray) -> FloatArray:
        nodes = quadrature_nodes(made, curve, low, high, simpson)
        u = made.left[nodes.segment] + nodes.t * made.length[nodes.segment]
        return np.bincount(nodes.interval, nodes.weight * np.exp(u))

    nodes = quadrature_nodes(made, curve, low, high, simpson)
    u = made.left[nodes.segment] + nodes.t * made.length[nodes.segment]
    for k, (lower, upper) in enumerate(((h, 0.0), (0.0, h))):
        slope = np.bincount(
            nodes.interval, np.exp(u) * (nodes.weight_slopes[:, k] + nodes.weight * nodes.node_slopes[:, k])
        )
        difference = (total(low + lower, high + upper) - total(low - lower, high - upper)) / (2 * h)
        np.testing.assert_allclose(slope, difference, rtol=1e-8)
