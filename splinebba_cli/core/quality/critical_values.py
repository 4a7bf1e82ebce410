"""Critical values of tests of single observations, and the noncentrality that gives a power.

one of n tests, alpha for all     Sidak 1 - (1 - alpha)^(1/n),  Bonferroni alpha / n
w    (sigma0 known)               k = normal quantile of 1 - alpha/2                         (Baarda 1968)
tau  (sigma0 estimated)           k = sqrt(r) t / sqrt(r - 1 + t^2),  t of r - 1 degrees     (Pope 1976)
power                             P(|N(delta0, 1)| > k) = 1 - beta
"""

from __future__ import annotations

import numpy as np
from scipy.special import chndtrinc, ndtr, ndtri, stdtrit

from splinebba_cli.core.settings import LocalTesting, Multiplicity

SMALLEST_ALPHA = 1e-15


def single_alpha(alpha: float, multiplicity: Multiplicity, tests: int) -> float:
    """Significance of one of `tests` tests."""
    if multiplicity == "none" or tests <= 1:
        return alpha
    if multiplicity == "bonferroni":
        return max(alpha / tests, SMALLEST_ALPHA)
    return max(float(-np.expm1(np.log1p(-alpha) / tests)), SMALLEST_ALPHA)


def critical_w(alpha: float) -> float:
    """Two-sided critical value of the normal distribution."""
    return float(-ndtri(alpha / 2.0))


def critical_tau(alpha: float, redundancy: float) -> float:
    """Two-sided critical value of Pope's tau; never above sqrt(redundancy), its largest possible value."""
    if redundancy <= 1.0:
        return float(np.sqrt(max(redundancy, 0.0)))
    t = -float(stdtrit(redundancy - 1.0, alpha / 2.0))
    return float(np.sqrt(redundancy) * t / np.sqrt(redundancy - 1.0 + t * t))


def critical_value(testing: LocalTesting, tests: int, redundancy: float) -> float:
    """Critical value of |w| or |tau| for one of `tests` observations of an adjustment."""
    alpha = single_alpha(testing.alpha, testing.multiplicity, tests)
    return critical_w(alpha) if testing.statistic == "w" else critical_tau(alpha, redundancy)


def power_of_w(noncentrality: float, critical: float) -> float:
    """Probability that |w| exceeds `critical` where a bias moves w by `noncentrality`."""
    return float(ndtr(noncentrality - critical) + ndtr(-noncentrality - critical))


def noncentrality(alpha: float, power: float) -> float:
    """delta0(alpha, beta): the shift of w that a two-sided test of significance alpha finds with `power` = 1 - beta.

    4.13 for alpha = 0.001 and power 0.8 (Baarda 1968).  0 where the power is not above alpha.
    """
    if power <= alpha:
        return 0.0
    return float(np.sqrt(chndtrinc(critical_w(alpha) ** 2, 1.0, 1.0 - power)))  # w^2 is noncentral chi-square
