"""Variance of unit weight of an adjustment in which residuals have taken weight from labelled points.

Points with large residuals are those that lose weight: v'Pv over the whole redundancy, or over the sum of the weights,
is too small.  For normal residuals of standard deviation sigma and weights p(v / s) of a scale s

    E[v'Pv] = sigma^2 (n + kappa sum p - u),   kappa = E[z^2 p(z sigma / s)] / E[p(z sigma / s)],   z standard normal,

n the other measurements, u the unknowns.  kappa depends on sigma, which is found by iteration; wrong labels, which
have hardly any weight, count neither on the left nor on the right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.hermite_e import hermegauss
from scipy.special import chdtri

from splinebba_cli.core.revision.graduated_weights import weights

NODES, SHARES = hermegauss(48)
STEPS = 20
SETTLED = 1e-4  # relative, of sigma^2
ALPHA = 0.001  # of the test whether residuals are larger than stated


@dataclass(frozen=True)
class UnitVariance:
    """A variance of unit weight and its redundancy; NaN and 0 where there is none."""

    variance: float
    redundancy: float

    @property
    def sigma0(self) -> float:
        """Its square root."""
        return float(np.sqrt(self.variance))

    @property
    def largest(self) -> float:
        """What sigma0 exceeds once in a thousand times where the stated sigma are right; inf without redundancy."""
        return float(np.sqrt(chdtri(self.redundancy, ALPHA) / self.redundancy)) if self.redundancy else np.inf

    @property
    def noise(self) -> float:
        """Factor of the stated sigma of points: sigma0 where that refutes them, else 1."""
        return self.sigma0 if self.sigma0 > self.largest else 1.0


def unit_variance(
    cost: float, others: float, total_weight: float, unknowns: float, scale: float
) -> UnitVariance:
    """Variance of unit weight.

    Parameters
    ----------
    cost : v'Pv of all measurements
    others : number of measurements without such weights
    total_weight : sum of the weights of the labelled points
    unknowns : number
    scale : of the weights, in the stated sigma of points; inf where all weights are 1
    """
    variance, redundancy = np.nan, 0.0
    for _ in range(STEPS):
        before = variance
        usual = 1.0 if np.isnan(variance) else float(np.sqrt(variance))
        redundancy = others + _kappa(scale / max(usual, 1e-12)) * total_weight - unknowns
        if redundancy <= 0.0:
            return UnitVariance(np.nan, 0.0)
        variance = cost / redundancy
        if abs(variance - before) <= SETTLED * variance:
            break
    return UnitVariance(float(variance), redundancy)


def _kappa(scale: float) -> float:
    """Weighted mean square of standard normal residuals for a scale of the weights."""
    p = SHARES * weights(np.abs(NODES), scale, np.ones(len(NODES)))
    return float(np.sum(p * NODES**2) / np.sum(p))
