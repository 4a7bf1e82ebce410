"""Critical values against printed tables and scipy's distributions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from splinebba_cli.core.quality.critical_values import (
    critical_tau,
    critical_value,
    critical_w,
    noncentrality,
    power_of_w,
    single_alpha,
)
from splinebba_cli.core.settings import LocalTesting


def test_values_that_tables_print() -> None:
    assert round(critical_w(0.001), 2) == 3.29
    assert round(critical_w(0.05), 3) == 1.960
    assert round(noncentrality(0.001, 0.8), 2) == 4.13  # Baarda
    assert round(noncentrality(0.05, 0.8), 2) == 2.80
    assert round(noncentrality(0.05, 0.9), 2) == 3.24


@pytest.mark.parametrize("alpha", [1e-6, 0.001, 0.05])
@pytest.mark.parametrize("power", [0.3, 0.5, 0.8, 0.999])
def test_noncentrality_gives_the_power(alpha: float, power: float) -> None:
    shift = stats.norm(noncentrality(alpha, power))
    k = critical_w(alpha)
    assert shift.sf(k) + shift.cdf(-k) == pytest.approx(power, abs=1e-10)
    assert power_of_w(noncentrality(alpha, power), k) == pytest.approx(power, abs=1e-10)


def test_no_power_asked_for() -> None:
    assert noncentrality(0.05, 0.05) == 0.0


@pytest.mark.parametrize("redundancy", [2, 5, 30])
def test_tau_is_exceeded_at_the_rate_alpha(redundancy: int) -> None:
    """tau of one component of a normal vector of `redundancy` components over its root mean square."""
    draw = np.random.default_rng(3).normal(size=(200_000, redundancy))
    tau = draw[:, 0] / np.sqrt(np.mean(draw**2, axis=1))
    rate = float(np.mean(np.abs(tau) > critical_tau(0.05, redundancy)))
    low, high = stats.binom.interval(0.999, 200_000, 0.05)
    assert low <= rate * 200_000 <= high


def test_tau_meets_w_where_redundancy_is_large_and_never_passes_its_bound() -> None:
    assert critical_tau(0.001, 1e7) == pytest.approx(critical_w(0.001), abs=1e-5)
    assert critical_tau(1e-12, 3) <= np.sqrt(3)
    assert critical_tau(0.05, 1) == 1.0


def test_many_tests_together() -> None:
    assert single_alpha(0.05, "none", 1000) == 0.05
    assert single_alpha(0.05, "bonferroni", 1000) == pytest.approx(5e-5)
    assert (1.0 - single_alpha(0.05, "sidak", 1000)) ** 1000 == pytest.approx(0.95)
    assert single_alpha(0.05, "bonferroni", 1000) < single_alpha(0.05, "sidak", 1000) < 0.05
    assert critical_value(LocalTesting(alpha=0.05, multiplicity="sidak"), 1000, 50) > 3.8
    assert critical_value(LocalTesting(statistic="tau"), 1, 8) < critical_value(LocalTesting(), 1, 8)
