"""Global test of the adjustment: r sigma0^2 / sigma0_prior^2 against two chi-square quantiles (Lee 4.6)."""

from __future__ import annotations

import math

from scipy.special import chdtri

from splinebba_cli.core.result import GlobalTest


def chi_square_quantile(probability: float, degrees: float) -> float:
    """Quantile of the chi-square distribution."""
    return float(chdtri(degrees, 1.0 - probability))


def global_test(vtpv: float, redundancy: float, sigma0_prior: float, alpha: float) -> GlobalTest | None:
    """Two-sided test of v'Pv / sigma0_prior^2; None without redundancy.

    Parameters
    ----------
    vtpv : float
        v'Pv with P = sigma0_prior^2 / sigma^2.
    alpha : float
        Significance, 0 < alpha < 1.
    """
    if redundancy < 1:
        return None
    statistic = vtpv / sigma0_prior**2
    lower = chi_square_quantile(alpha / 2.0, redundancy)
    upper = chi_square_quantile(1.0 - alpha / 2.0, redundancy)
    return GlobalTest(
        statistic, lower, upper, alpha, bool(lower <= statistic <= upper and math.isfinite(statistic))
    )
