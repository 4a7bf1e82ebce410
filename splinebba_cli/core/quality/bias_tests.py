"""Tests of a solution against a common bias of many observations, observations + C b with a few unknown b.

Whitened residuals v = adjusted - measured and R = I - A Q A' (residual_projector.py):

    b       = -(C'R C)^-1 C'v,   Q_bb = (C'R C)^-1
    T       = (C'v)' (C'R C)^-1 C'v / sigma0_prior^2       chi-square of q degrees without a bias
    T_F     = T (r - q) / (v'v - T)                        q times F(q, r - q): sigma0 estimated
    lambda0 = noncentrality of power 1 - beta,  MDB = sqrt(lambda0 / largest eigenvalue of C'R C)

The generalised likelihood ratio test; with one observation and C a unit vector it is Baarda's w.  Directions that the
unknowns take up (C'R C without rank) are left out: no residual shows them.
(Baarda 1968; Foerstner 1983; Teunissen 2000, Testing theory, chapter 4)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import sparse
from scipy.special import chdtrc, chndtrinc, fdtrc, fdtri

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.global_test import chi_square_quantile
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Statistics
from splinebba_cli.core.settings import LocalTesting, TestStatistic

SHOWN = 1e-4  # share of a bias that its residuals must show, in the whitened norm


@dataclass(frozen=True)
class BiasTest:
    """One test; the estimate is in the unit of the directions' bias."""

    estimate: FloatArray  # (p,) b, NaN where no residual shows it
    sigma: FloatArray  # (p,) a priori sigma0
    statistic: float
    freedom: int  # q, number of directions that residuals show; 0: no test
    probability: float  # of a statistic at least as large without a bias
    shown: float  # largest share of a bias that the residuals show, 0 .. 1
    minimal_detectable: float
    plain: FloatArray  # (p,) mean bias that is left in the residuals, -(C'C)^-1 C'v
    plain_sigma: FloatArray  # (p,) its standard deviation without a bias


@dataclass(frozen=True)
class TestFamily:
    """What all tests of one family share: alpha belongs to all of them together."""

    statistic: TestStatistic
    alpha: float
    power: float
    redundancy: float
    vtpv: float  # whitened
    tests: int

    @classmethod
    def of(cls, statistics: Statistics, testing: LocalTesting, alpha: float, tests: int) -> TestFamily:
        """The family of `tests` tests of an adjustment."""
        whitened = statistics.vtpv / statistics.sigma0_prior**2
        return cls(testing.statistic, alpha, testing.power, statistics.redundancy, whitened, tests)

    @property
    def single_alpha(self) -> float:
        """Significance of one test (Sidak)."""
        return single_alpha(self.alpha, "sidak", self.tests)

    def critical(self, freedom: int) -> float:
        """Critical value of the statistic with `freedom` degrees."""
        if self.statistic == "w" or self.redundancy <= freedom:
            return chi_square_quantile(1.0 - self.single_alpha, freedom)
        return freedom * float(fdtri(freedom, self.redundancy - freedom, 1.0 - self.single_alpha))

    def statistic_of(self, chi_square: float, freedom: int) -> float:
        """T, or T_F where sigma0 is estimated."""
        rest = self.vtpv - chi_square
        if self.statistic == "w" or self.redundancy <= freedom or rest <= 0.0:
            return chi_square
        return chi_square * (self.redundancy - freedom) / rest

    def probability(self, statistic: float, freedom: int) -> float:
        """Probability of a statistic at least as large without a bias."""
        if self.statistic == "w" or self.redundancy <= freedom:
            return float(chdtrc(freedom, statistic))
        return float(fdtrc(freedom, self.redundancy - freedom, statistic / freedom))

    def of_all(self, probability: float) -> float:
        """The same of the smallest of all tests of the family (Sidak)."""
        return float(-np.expm1(self.tests * np.log1p(-min(probability, 1.0 - 1e-16))))


@cache
def noncentrality_of(alpha: float, power: float, freedom: int) -> float:
    """lambda0: noncentrality that a chi-square test of `freedom` degrees finds with a given power.

    17.07 = 4.13^2 for alpha = 0.001, power 0.8 and one degree (Baarda 1968).
    """
    if power <= alpha:
        return 0.0
    return float(chndtrinc(chi_square_quantile(1.0 - alpha, freedom), freedom, 1.0 - power))


def bias_tests(
    projector: ResidualProjector, blocks: list[sparse.csc_array], family: TestFamily
) -> list[BiasTest]:
    """Test every block of directions (rows, p), whitened per unit of the bias."""
    residual = projector.design.residual
    return [
        _tested(np.asarray(block.T @ residual), inner, gram, family)
        for block, (inner, gram) in zip(blocks, projector.grams(blocks), strict=True)
    ]


def _tested(moment: FloatArray, inner: FloatArray, gram: FloatArray, family: TestFamily) -> BiasTest:
    """The test with C'v (p,), C'C and C'R C (p, p)."""
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    normed, g, m = inner / np.outer(scale, scale), gram / np.outer(scale, scale), moment / scale
    size, axes = np.linalg.eigh(normed)
    whole = size > 1e-9
    unit = axes[:, whole] / np.sqrt(size[whole])  # directions of unit size in the whitened norm
    values, vectors = np.linalg.eigh(unit.T @ g @ unit)
    kept = values > SHOWN
    basis, hidden = unit @ vectors[:, kept], np.hstack([unit @ vectors[:, ~kept], axes[:, ~whole]])
    hidden /= np.maximum(np.linalg.norm(hidden, axis=0), 1e-300)
    inverse = (basis / values[kept]) @ basis.T
    seen = np.abs(hidden).max(axis=1, initial=0.0) < 0.01  # the others have a part that unknowns take up
    q, whole_inverse = int(kept.sum()), unit @ unit.T
    statistic = family.statistic_of(float(m @ inverse @ m), q) if q else 0.0
    noncentrality = noncentrality_of(family.single_alpha, family.power, q) if q else np.inf
    return BiasTest(
        estimate=np.where(seen, -inverse @ m / scale, np.nan),
        sigma=np.where(seen, np.sqrt(np.diag(inverse)) / scale, np.nan),
        statistic=statistic,
        freedom=q,
        probability=family.probability(statistic, q) if q else 1.0,
        shown=float(np.clip(values.max(initial=0.0), 0.0, 1.0)),
        minimal_detectable=float(np.sqrt(noncentrality / np.linalg.eigvalsh(gram)[-1])) if q else np.inf,
        plain=-(whole_inverse @ m) / scale,
        plain_sigma=np.sqrt(np.maximum(np.diag(whole_inverse @ g @ whole_inverse), 0.0)) / scale,
    )
