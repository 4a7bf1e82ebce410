"""Tests of sets of parameters: d'C^-1 d of several sets at once, and tests of additional parameters.

Wald        d'C^-1 d of k components: chi-square of k, or k times F of (k, r) where sigma0^2 is estimated from r
            degrees of freedom that are independent of d
Hausman     C = Q_part - Q_whole: directions in which the whole adds little have no information, and their variance
            is a difference of nearly equal numbers.  With Q_part = L L' (any root), C is taken in the eigenvectors of
            L^-1 C L^-T, whose eigenvalues are the shares of the variance that the whole takes away, 0 to 1; those
            below a threshold are left out, and the degrees of freedom with them.  (Hausman 1978, Econometrica 46)
additional  F = ((v'Pv_0 - v'Pv_1) / (r_0 - r_1)) / (v'Pv_1 / r_1) for models 0 inside of 1 (Koch 1999, section 4.2)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

SMALLEST = 1e-14  # eigenvalue of a correlation matrix: beyond it is rounding
SHARE = 1e-3  # of the variance: less is not told apart from the change of the linearisation


@dataclass(frozen=True)
class ParameterTests:
    """Tests of n sets of parameters."""

    statistic: FloatArray  # (n,) d'C^-1 d
    dimensions: IntArray  # (n,) degrees of freedom; 0: nothing is tested
    probability: (
        FloatArray  # (n,) of a larger statistic where the parameters are equal; NaN where nothing is tested
    )

    def significant(self, alpha: float) -> BoolArray:
        """Sets whose difference is significant, (n,)."""
        return np.asarray(np.nan_to_num(self.probability, nan=1.0) < alpha)


def wald_tests(
    difference: FloatArray, dispersion: FloatArray, reference: FloatArray, degrees: float | None
) -> ParameterTests:
    """Tests of differences (n, k) with dispersions (n, k, k).

    Parameters
    ----------
    dispersion : (n, k, k) float
        Of the differences.
    reference : (n, k, k) float
        Positive definite but for parameters that are held (variance 0): the dispersion itself, or that of the less
        precise adjustment where `dispersion` is a difference of two.
    degrees : float or None
        Degrees of freedom of the variance factor in `dispersion`; None: it is known.
    """
    variance = np.einsum("nii->ni", reference)
    free = variance > 0.0
    sigma = np.where(free, np.sqrt(np.where(free, variance, 1.0)), 1.0)
    scaled = reference / (sigma[:, :, None] * sigma[:, None, :])
    scaled = np.where(free[:, :, None] & free[:, None, :], scaled, 0.0) + ~free[:, :, None] * np.eye(
        free.shape[1]
    )
    spread, axes = np.linalg.eigh(scaled)
    inverse_root = axes.transpose(0, 2, 1) / np.sqrt(np.maximum(spread, SMALLEST))[:, :, None]
    normal = np.where(free, difference, 0.0) / sigma
    inner = dispersion / (sigma[:, :, None] * sigma[:, None, :]) * (free[:, :, None] & free[:, None, :])
    whitened = inverse_root @ inner @ inverse_root.transpose(0, 2, 1)
    values, vectors = np.linalg.eigh(0.5 * (whitened + whitened.transpose(0, 2, 1)))
    along = np.einsum("nij,nik,nk->nj", vectors, inverse_root, normal)
    kept = values > SHARE
    statistic = np.sum(np.where(kept, along**2 / np.where(kept, values, 1.0), 0.0), axis=1)
    dimensions = kept.sum(axis=1)
    return ParameterTests(statistic, dimensions, upper_probability(statistic, dimensions, degrees))


def upper_probability(statistic: FloatArray, dimensions: IntArray, degrees: float | None) -> FloatArray:
    """Probability that a quadratic form exceeds `statistic`; NaN of 0 dimensions."""
    safe = np.maximum(dimensions, 1)
    found = chdtrc(safe, statistic) if degrees is None else fdtrc(safe, degrees, statistic / safe)
    return np.asarray(np.where(dimensions > 0, found, np.nan))


@dataclass(frozen=True)
class RatioTest:
    """A ratio of two variances against the F distribution, or of a sum of squares against chi-square."""

    statistic: float
    numerator: float  # degrees of freedom
    denominator: float | None  # None: against a known variance, chi-square
    lower: float  # accepted interval; 0 of a one-sided test
    upper: float
    alpha: float
    probability: float
    significant: bool
