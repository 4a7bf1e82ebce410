"""Figures of many runs, and the intervals that a correct program keeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import bdtr, betaincinv, chdtri, fdtri

from splinebba_cli.core.network import BoolArray, FloatArray

CONFIDENCE = 0.99


@dataclass(frozen=True)
class Figure:
    """A figure of many runs and the interval that a correct program keeps with 99 % probability."""

    value: float
    lower: float
    upper: float

    @property
    def inside(self) -> bool:
        """Whether the figure lies in its interval."""
        return self.lower <= self.value <= self.upper


def mean_square_interval(freedom: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Two-sided interval of chi-square over its degrees of freedom."""
    tail = 0.5 * (1.0 - confidence)
    return float(chdtri(freedom, 1.0 - tail)) / freedom, float(chdtri(freedom, tail)) / freedom


def ratio_interval(runs: int, elements: int = 1) -> tuple[float, float]:
    """Interval of the root mean square of `runs` normalised errors; of `elements` together by Bonferroni."""
    lower, upper = mean_square_interval(runs, 1.0 - (1.0 - CONFIDENCE) / max(elements, 1))
    return float(np.sqrt(lower)), float(np.sqrt(upper))


def binomial_interval(count: int, probability: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Shares between which a binomial variable lies with at least the given probability."""
    tail = 0.5 * (1.0 - confidence)
    below = bdtr(np.arange(count + 1.0), count, probability)  # P(successes <= k)
    lower = int(np.searchsorted(below, tail, side="right"))
    upper = int(np.searchsorted(below, 1.0 - tail, side="left"))
    return lower / count, min(upper, count) / count


def estimated_share(successes: int, count: int, confidence: float = CONFIDENCE) -> Figure:
    """An observed share and the interval of the true one (Clopper and Pearson 1934)."""
    tail = 0.5 * (1.0 - confidence)
    lower = 0.0 if successes == 0 else float(betaincinv(successes, count - successes + 1, tail))
    upper = 1.0 if successes == count else float(betaincinv(successes + 1, count - successes, 1.0 - tail))
    return Figure(successes / count, lower, upper)


def within_confidence(
    squares: FloatArray,
    freedom: FloatArray | float,
    sigma0: FloatArray,
    redundancy: FloatArray,
    confidence: float,
) -> BoolArray:
    """Whether true values lie in the confidence regions of their estimates.

    With q = eᵀ D⁻¹ e of an a-priori dispersion D and f elements, q ~ χ²_f; of a dispersion scaled by σ̂₀²,
    q / (f σ̂₀²) ~ F(f, r).  f = 1 is the interval of a single value (normal, Student).

    Parameters
    ----------
    squares : (N, …) q of every run
    freedom : f, broadcast to `squares`
    sigma0 : (N,) σ̂₀/σ₀ by which the reported σ of a run were scaled; NaN where they were not
    redundancy : (N,) r of every run
    """
    shape = (len(squares),) + (1,) * (squares.ndim - 1)
    scaled = np.isfinite(sigma0).reshape(shape)
    factor = np.where(scaled, np.where(np.isfinite(sigma0), sigma0, 1.0).reshape(shape) ** 2, 1.0)
    many = np.maximum(np.asarray(redundancy, dtype=np.float64), 1.0).reshape(shape)
    f = np.maximum(np.broadcast_to(np.asarray(freedom, dtype=np.float64), squares.shape), 1.0)
    limit = np.where(scaled, f * fdtri(f, many, confidence), chdtri(f, 1.0 - confidence))
    with np.errstate(invalid="ignore"):
        return np.asarray(squares / factor <= limit)
