"""Global test of the adjustment: r sigma0^2 / sigma0_prior^2 against two chi-square quantiles (Lee 4.6)."""

from __future__ import annotations

import math

from scipy.special import chdtri

from splinebba_cli.core.result import GlobalTest


def chi_square_quantile(probability: float, degrees: float) -> float:
    """Quantile of the chi-square distribution."""
    return float(chdtri(degrees, 1.0 - probability))


def global_test(
    vtpv: float, redundancy: float, sigma0_prior: float, alpha: float, from_conditions: float = 0.0
) -> GlobalTest | None:
    """Two-sided test of v'Pv / sigma0_prior^2; None without redundancy.

    Parameters
    ----------
    vtpv : float
        v'Pv with P = sigma0_prior^2 / sigma^2.
    alpha : float
        Significance, 0 < alpha < 1.
    from_conditions : float
        Part of the redundancy that gauge conditions have.  They are no measurements: how far off their reference is,
        nobody knows, so that their part of v'Pv is anything between 0 and this on the average.  The lower bound leaves
        them out, the upper one counts them.
    """
    if redundancy < 1:
        return None
    statistic = vtpv / sigma0_prior**2
    measured = redundancy - from_conditions
    lower = chi_square_quantile(alpha / 2.0, measured) if measured > 0.0 else 0.0
    upper = chi_square_quantile(1.0 - alpha / 2.0, redundancy)
    return GlobalTest(
        statistic, lower, upper, alpha, bool(lower <= statistic <= upper and math.isfinite(statistic))
    )
