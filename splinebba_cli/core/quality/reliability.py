"""Internal and external reliability of observations, from their redundancy numbers r = 1 - a Q a'.

    minimal detectable bias       nabla0 = delta0 sigma / sqrt(r)
    bias-to-noise ratio           delta0 sqrt((1 - r) / r): largest effect of nabla0 on a function of the unknowns, in
                                  standard deviations of the function
    on the orientation of image   delta0 sqrt(a Q_.i Q_ii^-1 Q_i. a' / r): the same of functions of this orientation

(Baarda 1968; Foerstner 1987; theory, section 7)
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import LocalTests, Reliability
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import critical_value, noncentrality, single_alpha
from splinebba_cli.core.result import AdjustmentResult, Statistics
from splinebba_cli.core.settings import LocalTesting

CONTROLLED = 1e-9  # redundancy number below which no error is ever found


def standardized_residuals(whitened: FloatArray, redundancy: FloatArray) -> FloatArray:
    """w = v / (sigma sqrt(r)) of whitened residuals v / sigma; NaN where nothing is controlled."""
    return np.where(redundancy > CONTROLLED, whitened / np.sqrt(np.maximum(redundancy, CONTROLLED)), np.nan)


def reliability(
    sigma: FloatArray, redundancy: FloatArray, orientation_share: FloatArray, delta0: float
) -> Reliability:
    """Reliability of observations of any shape.

    Parameters
    ----------
    sigma : a priori standard deviation, in the unit that the minimal detectable bias is to have
    redundancy : redundancy numbers, NaN where there is no observation
    orientation_share : part of the leverage that the orientation of the image has
    delta0 : noncentrality
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = np.where(redundancy > CONTROLLED, 1.0 / redundancy, np.inf)
        inverse = np.where(np.isnan(redundancy), np.nan, inverse)
        share = np.maximum(orientation_share, 0.0)
        influence = np.where(share > 0.0, delta0 * np.sqrt(share * inverse), 0.0)
        return Reliability(
            minimal_detectable_bias=delta0 * sigma * np.sqrt(inverse),
            bias_to_noise=delta0 * np.sqrt(np.maximum(1.0 - redundancy, 0.0) * inverse),
            orientation_influence=np.where(np.isnan(redundancy), np.nan, influence),
        )


def delta0_of(testing: LocalTesting, tests: int) -> float:
    """Noncentrality of the chosen significance and power."""
    return noncentrality(single_alpha(testing.alpha, testing.multiplicity, tests), testing.power)


def tested_values(testing: LocalTesting, standardized: FloatArray, statistics: Statistics) -> FloatArray:
    """What is held against the critical value: w, or tau = w sigma0_prior / sigma0."""
    if testing.statistic == "w":
        return standardized
    return standardized * (statistics.sigma0_prior / statistics.sigma0)


def local_tests_of(result: AdjustmentResult) -> LocalTests:
    """What all tests of single observations of an adjustment share."""
    testing, statistics = result.network.settings.testing, result.statistics
    w = np.concatenate(
        [
            result.point_residuals.standardized.ravel(),
            result.curve_residuals.standardized.ravel(),
            result.arc_residuals.standardized,
            result.tangent_residuals.standardized,
            result.distance_residuals.standardized,
            result.prior_residuals.standardized,
        ]
    )
    size = np.abs(tested_values(testing, w[np.isfinite(w)], statistics))
    critical = critical_value(testing, len(size), statistics.redundancy)
    return LocalTests(
        statistic=testing.statistic,
        alpha=testing.alpha,
        multiplicity=testing.multiplicity,
        alpha_single=single_alpha(testing.alpha, testing.multiplicity, len(size)),
        power=testing.power,
        tests=len(size),
        critical=critical,
        noncentrality=delta0_of(testing, len(size)),
        beyond=int((size > critical).sum()),
    )
