"""Two adjustments by their variances of unit weight.

independent    s_a^2 / s_b^2 ~ F of (r_a, r_b), two-sided
nested models  F = ((v'Pv_0 - v'Pv_1) / (r_0 - r_1)) / (v'Pv_1 / r_1) ~ F of (r_0 - r_1, r_1), one-sided: the same
               observations with fewer (0) and more (1) unknowns; with sigma0 known the numerator alone, chi-square
"""

from __future__ import annotations

from dataclasses import dataclass

from scipy.special import chdtrc, chdtri, fdtr, fdtrc, fdtri

from splinebba_cli.core.quality.parameter_test import RatioTest


@dataclass(frozen=True)
class SumOfSquares:
    """v'Pv in units of the a-priori variance of unit weight, and its redundancy."""

    vtpv: float
    redundancy: float

    @property
    def variance(self) -> float:
        """Variance of unit weight over its a-priori value."""
        return self.vtpv / self.redundancy


def equal_variances(a: SumOfSquares, b: SumOfSquares, alpha: float) -> RatioTest | None:
    """Two-sided F test of the variances of two independent adjustments; None without redundancy."""
    if min(a.redundancy, b.redundancy) < 1 or b.vtpv <= 0.0:
        return None
    ratio = a.variance / b.variance
    lower = float(fdtri(a.redundancy, b.redundancy, 0.5 * alpha))
    upper = float(fdtri(a.redundancy, b.redundancy, 1.0 - 0.5 * alpha))
    below, above = fdtr(a.redundancy, b.redundancy, ratio), fdtrc(a.redundancy, b.redundancy, ratio)
    probability = float(min(2.0 * min(below, above), 1.0))
    return RatioTest(
        ratio, a.redundancy, b.redundancy, lower, upper, alpha, probability, not lower <= ratio <= upper
    )


def additional_parameters(
    smaller: SumOfSquares, larger: SumOfSquares, alpha: float, *, sigma0_known: bool
) -> RatioTest | None:
    """Test of the parameters that the larger model has beyond the smaller one; None where there are none.

    Parameters
    ----------
    smaller, larger : SumOfSquares
        Of the same observations with fewer and with more unknowns.
    sigma0_known : bool
        Whether the variance of unit weight is the a-priori one, not that of the larger model.
    """
    count = smaller.redundancy - larger.redundancy
    gain = max(smaller.vtpv - larger.vtpv, 0.0)
    if count < 1:
        return None
    if sigma0_known or larger.redundancy < 1:
        upper = float(chdtri(count, alpha))
        return RatioTest(gain, count, None, 0.0, upper, alpha, float(chdtrc(count, gain)), gain > upper)
    ratio = gain / count / larger.variance
    upper = float(fdtri(count, larger.redundancy, 1.0 - alpha))
    probability = float(fdtrc(count, larger.redundancy, ratio))
    return RatioTest(ratio, count, larger.redundancy, 0.0, upper, alpha, probability, ratio > upper)
