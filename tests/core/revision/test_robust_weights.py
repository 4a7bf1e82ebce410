"""Weight functions: their defining properties, not their code."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from splinebba_cli.core.revision.robust_weights import (
    CAUCHY,
    DANISH,
    HUBER,
    TUKEY,
    WEIGHT_FUNCTIONS,
    cauchy,
    danish,
    huber,
    radial,
    tukey,
)

U = np.linspace(-12.0, 12.0, 24001)


@pytest.mark.parametrize("name", WEIGHT_FUNCTIONS)
def test_full_weight_at_zero_even_falling_and_continuous(name: str) -> None:
    weight = WEIGHT_FUNCTIONS[name](U)
    assert weight[len(U) // 2] == 1.0
    np.testing.assert_allclose(weight, weight[::-1])
    assert (np.diff(weight[U >= 0.0]) <= 1e-15).all()
    assert np.abs(np.diff(weight)).max() < 2e-3  # a step of 0.001 in u


@pytest.mark.parametrize(("name", "efficiency"), [("huber", 0.95), ("cauchy", 0.95), ("tukey", 0.95)])
def test_constants_give_their_efficiency_for_normal_errors(name: str, efficiency: float) -> None:
    """Asymptotic efficiency (E psi')^2 / E psi^2 of psi = u p(u), by integration over the normal density."""
    psi, density = U * WEIGHT_FUNCTIONS[name](U), norm.pdf(U)
    slope = np.trapezoid(np.gradient(psi, U) * density, U)
    assert slope**2 / np.trapezoid(psi**2 * density, U) == pytest.approx(efficiency, abs=5e-4)


def test_at_the_constants() -> None:
    assert huber(np.array([HUBER, 2.0 * HUBER])).tolist() == [1.0, 0.5]
    assert cauchy(np.array([CAUCHY]))[0] == 0.5
    assert tukey(np.array([TUKEY, 1e3])).tolist() == [0.0, 0.0]
    assert danish(np.array([DANISH]))[0] == 1.0
    assert danish(np.array([2.0 * DANISH]))[0] == pytest.approx(np.exp(-3.0))


def test_radial_value_is_as_improbable_as_the_two() -> None:
    both = np.array([[0.3, -0.4], [3.0, 4.0], [30.0, 40.0], [np.nan, 2.0]])
    u = radial(both)
    rho = np.sqrt(np.nansum(both**2, axis=1))
    np.testing.assert_allclose(2.0 * norm.sf(u[:2]), np.exp(-0.5 * rho[:2] ** 2))
    assert 49.9 < u[2] < 50.0  # far out the same as the radius
    turned = both[1] @ np.array([[0.6, -0.8], [0.8, 0.6]])
    assert radial(turned[None])[0] == pytest.approx(u[1])
    assert radial(np.zeros((1, 2)))[0] == 0.0
