"""Tests of the variances of all groups, and what follows for their sigma.

    f_g s_g against chi-square quantiles of f_g degrees, two-sided               (the group against its given sigma)
    s_g / s_rest against quantiles of F(f_g, f_rest), two-sided                  (the group against all others)

alpha belongs to all groups together (Sidak).  A sigma is questioned only where both tests fail: one factor that all
groups share is the business of the global test.
"""

from __future__ import annotations

import numpy as np
from scipy.special import fdtr, fdtrc

from splinebba_cli.core.evidence import VarianceComponent
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.global_test import chi_square_quantile
from splinebba_cli.core.quality.group_sums import GroupSum
from splinebba_cli.core.quality.group_variances import GroupVariances
from splinebba_cli.core.result import Problem
from splinebba_cli.core.settings import OutlierPolicy

FREEDOM_NEEDED = 5.0  # a sigma estimated with less is good to 1 / sqrt(2 f) = 32 % at best
EXACT = 1e-6  # of the sigma used: measurements without noise say nothing about it
MATERIAL = 1.3  # factor from which a wrong sigma is a warning
SIGMA_KEYS = {"point": "sigma_px", "spline": "sigma_px"}


def variance_components(
    sums: list[GroupSum], variances: GroupVariances, factors: FloatArray, estimated: FloatArray, alpha: float
) -> tuple[VarianceComponent, ...]:
    """One component a group; `factors` are those that its sigma has already, (G,), where `estimated`."""
    single = single_alpha(alpha, "sidak", len(sums))
    found = []
    for k, each in enumerate(sums):
        s, f = float(variances.variance[k]), float(variances.freedom[k])
        known = np.isfinite(s) and f > 0.0
        bounds = [chi_square_quantile(p, f) if known else np.nan for p in (single / 2.0, 1.0 - single / 2.0)]
        found.append(
            VarianceComponent(
                group=each.group.name,
                kind=each.group.kind,
                observations=each.equations,
                redundancy=each.redundancy,
                sigma0=float(np.sqrt(s)),
                sigma0_sigma=float(np.sqrt(0.5 * s / f)) if known else np.nan,
                factor=float(factors[k]),
                statistic=f * s if known else np.nan,
                lower=bounds[0],
                upper=bounds[1],
                passed=not known or bool(bounds[0] <= f * s <= bounds[1]),
                freedom=f,
                estimated=bool(estimated[k]),
            )
        )
    return tuple(found)


def differs(component: VarianceComponent, others: list[VarianceComponent], alpha: float) -> bool:
    """F test of one group against all others together, two-sided."""
    others = [each for each in others if each.freedom > 0.0 and np.isfinite(each.sigma0)]
    freedom = sum(each.freedom for each in others)
    rest = sum(each.statistic for each in others)
    if component.freedom <= 0.0 or rest <= 0.0:
        return False
    ratio = component.sigma0**2 / (rest / freedom)
    tail = min(fdtr(component.freedom, freedom, ratio), fdtrc(component.freedom, freedom, ratio))
    return bool(2.0 * tail < alpha)


def component_findings(
    components: tuple[VarianceComponent, ...], alpha: float, outliers: OutlierPolicy
) -> list[Problem]:
    """Groups whose sigma does not fit to those of the others.

    Where residuals reduce weights, they make every estimate smaller: no sigma is then called too large.
    """
    single = single_alpha(alpha, "sidak", len(components))
    found = []
    for k, own in enumerate(components):
        others = [*components[:k], *components[k + 1 :]]
        weak = own.freedom < FREEDOM_NEEDED or own.sigma0 <= EXACT
        if own.passed or weak or not differs(own, others, single):
            continue
        factor = own.sigma0
        small = factor > 1.0
        if outliers.reweights and not small:
            continue
        size = factor if small else 1.0 / factor
        subject = f"group `{own.group}`"
        message = (
            f"the σ of {subject} looks too {'small' if small else 'large'} by a factor {size:.2g}: its σ̂ is "
            f"{own.sigma0:.3g} ± {own.sigma0_sigma:.2g} of the given one"
        )
        help = f"multiply its σ by {factor:.2g}, or let it be estimated: `adjustment: {{variance_components: true}}`"
        if small:
            help = f"look at its largest residuals for gross errors; then {help}"
        found.append(Problem("SBB545", "warning" if size > MATERIAL else "info", message, subject, help))
    return found
