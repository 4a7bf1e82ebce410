"""What many runs say: bias, empirical against predicted dispersion, coverage, convergence from wrong starts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import ndtri

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.simulation.intervals import (
    CONFIDENCE,
    Figure,
    binomial_interval,
    estimated_share,
    ratio_interval,
)
from splinebba_cli.simulation.monte_carlo import MonteCarloResult
from splinebba_cli.simulation.run_record import Failure, RunRecord

HISTOGRAM_EDGES = np.linspace(-5.0, 5.0, 41)
Kind = Literal["eop", "points", "splines", "locations"]


@dataclass(frozen=True)
class ElementStatistics:
    """One estimated number over all runs that estimated it; units of the number (rad, m)."""

    runs: int
    bias: float
    bias_sigma: float  # standard deviation of the bias, from the scatter of the runs
    empirical: float  # root mean square error
    predicted: float  # root mean square of the predicted a-priori standard deviations
    ratio: Figure  # empirical over predicted, run by run
    coverage: Figure


@dataclass(frozen=True)
class SplineStatistics:
    """One curve over all runs, at places along it."""

    runs: int
    bias: FloatArray  # (2,) m, mean over its places: to the left in plan, upwards
    bias_sigma: FloatArray  # (2,) of these means, from the scatter of the runs
    largest_bias: float  # of a single place, in its own standard deviations
    largest_bias_place: float  # where that place is, as a share of the places along the curve
    largest_bias_limit: float  # exceeded by one of all places with 1 % probability
    empirical: float  # root mean square error across, m
    ratio: Figure
    coverage: Figure


@dataclass(frozen=True)
class KindStatistics:
    """All numbers of one kind together."""

    elements: int
    coverage: Figure
    smallest_ratio: float
    largest_ratio: float
    ratio_limits: tuple[float, float]  # that all elements keep together with 99 % probability (Bonferroni)


@dataclass(frozen=True)
class StudyStatistics:
    """Where starts of one size led."""

    factor: float
    runs: int
    same: Figure  # the interval is that of the true share (Clopper-Pearson)
    other_minimum: int
    failed: int
    iterations: float  # median of the runs that came back; NaN without any
    failures: tuple[tuple[Failure, int], ...]


def element_statistics(
    errors: FloatArray, normalized: FloatArray, covered: FloatArray, confidence: float
) -> ElementStatistics | None:
    """Statistics of one element, (N,) each; None where no run estimated it."""
    known = np.isfinite(normalized)
    count = int(known.sum())
    if count < 2:
        return None
    e, z = errors[known], normalized[known]
    ratio = float(np.sqrt(np.mean(z**2)))
    moved = z != 0.0
    sigma = e[moved] / z[moved]
    return ElementStatistics(
        runs=count,
        bias=float(e.mean()),
        bias_sigma=float(e.std(ddof=1) / np.sqrt(count)),
        empirical=float(np.sqrt(np.mean(e**2))),
        predicted=float(np.sqrt(np.mean(sigma**2))) if len(sigma) else 0.0,
        ratio=Figure(ratio, *ratio_interval(count)),
        coverage=Figure(float(covered[known].mean()), *binomial_interval(count, confidence)),
    )


def all_elements(
    result: MonteCarloResult, kind: Literal["eop", "points"], confidence: float
) -> list[list[ElementStatistics | None]]:
    """Statistics of every element of every image or point, [item][element]."""
    errors, normalized = (
        (result.errors, result.normalized)
        if kind == "eop"
        else (result.point_errors, result.point_normalized)
    )
    covered = result.covered(normalized**2, 1.0, confidence)
    return [
        [
            element_statistics(errors[:, i, j], normalized[:, i, j], covered[:, i, j], confidence)
            for j in range(errors.shape[2])
        ]
        for i in range(errors.shape[1])
    ]


def all_locations(result: MonteCarloResult, confidence: float) -> list[ElementStatistics | None]:
    """Statistics of every location on a curve whose every value is given, in units of its parameter.

    Of other curves there are none: what is along them depends on the datum (gauge conditions).
    """
    normalized = result.locations_normalized
    covered = result.covered(normalized**2, 1.0, confidence)
    return [
        element_statistics(result.locations[:, q], normalized[:, q], covered[:, q], confidence)
        for q in range(normalized.shape[1])
    ]


def largest_bias(items: Sequence[ElementStatistics | None]) -> tuple[float, float]:
    """Largest bias among elements in its own σ, and what one of them exceeds with 1 % probability."""
    biases = [abs(e.bias) / e.bias_sigma for e in items if e is not None and e.bias_sigma > 0.0]
    tail = 0.5 * (1.0 - CONFIDENCE) / max(len(biases), 1)
    return max(biases, default=0.0), float(-ndtri(tail))


def all_splines(result: MonteCarloResult, confidence: float) -> list[SplineStatistics | None]:
    """Statistics of every curve; None where none of it is estimated (control that is held)."""
    squares, freedom = lateral_squares(result)
    covered = result.covered(squares, freedom, confidence)
    return [
        _spline(result.across[:, k], result.across_normalized[:, k], covered[:, k], freedom[:, k], confidence)
        for k in range(result.across.shape[1])
    ]


def lateral_squares(result: MonteCarloResult) -> tuple[FloatArray, FloatArray]:
    """Squared lateral errors over the lateral ellipse (N, k, p), and their degrees of freedom: 2, 1 or 0 (NaN)."""
    known = np.isfinite(result.across_normalized)
    freedom = known.sum(axis=-1).astype(np.float64)
    squares = np.where(known, result.across_normalized, 0.0) ** 2
    return np.where(freedom > 0.0, squares.sum(axis=-1), np.nan), freedom


def _spline(
    across: FloatArray, normalized: FloatArray, covered: FloatArray, freedom: FloatArray, confidence: float
) -> SplineStatistics | None:
    """Statistics of one curve: (N, p, 2), (N, p, 2), (N, p), (N, p)."""
    runs = np.flatnonzero(np.isfinite(covered).any(axis=1))
    count = len(runs)
    if count < 2:
        return None
    places = np.flatnonzero(np.isfinite(across[runs]).all(axis=(0, 2)))
    own = across[np.ix_(runs, places)]
    mean_of_run = own.mean(axis=1)
    scatter = own.std(axis=0, ddof=1) / np.sqrt(count)
    single = np.abs(own.mean(axis=0)) / np.where(scatter > 0.0, scatter, np.inf)
    tail = 0.5 * (1.0 - CONFIDENCE) / max(single.size, 1)
    least = int(freedom[runs][freedom[runs] > 0.0].min())
    squares = normalized[runs][np.isfinite(normalized[runs])] ** 2
    return SplineStatistics(
        runs=count,
        bias=mean_of_run.mean(axis=0),
        bias_sigma=mean_of_run.std(axis=0, ddof=1) / np.sqrt(count),
        largest_bias=float(single.max(initial=0.0)),
        largest_bias_place=_share(places, single, across.shape[1]),
        largest_bias_limit=float(-ndtri(tail)),
        empirical=float(np.sqrt(np.mean(np.sum(own**2, axis=2)))),
        ratio=Figure(float(np.sqrt(squares.mean())), *ratio_interval(count * least)),
        coverage=Figure(float(np.nanmean(covered[runs])), *binomial_interval(count, confidence)),
    )


def _share(places: IntArray, single: FloatArray, count: int) -> float:
    """Where along the curve the largest bias is, 0 … 1."""
    if not single.size:
        return 0.0
    return float(places[np.argmax(single.max(axis=1))] / max(count - 1, 1))


def kind_statistics(
    items: Sequence[ElementStatistics | SplineStatistics | None], result: MonteCarloResult, confidence: float
) -> KindStatistics | None:
    """All elements of a kind together; None where there are none.

    The interval of the coverage is that of a single element: pooled, correlated elements keep a narrower one.
    """
    found = [item for item in items if item is not None]
    if not found:
        return None
    weights = np.array([item.runs for item in found], dtype=np.float64)
    share = float(np.average([item.coverage.value for item in found], weights=weights))
    ratios = [item.ratio.value for item in found]
    return KindStatistics(
        elements=len(found),
        coverage=Figure(share, *binomial_interval(result.solved, confidence)),
        smallest_ratio=min(ratios),
        largest_ratio=max(ratios),
        ratio_limits=ratio_interval(min(item.runs for item in found), len(found)),
    )


def histogram(values: FloatArray) -> list[int]:
    """Counts of normalised errors in the bins of HISTOGRAM_EDGES; what lies beyond is in the last bins."""
    finite = values[np.isfinite(values)]
    counts = np.histogram(np.clip(finite, -5.0 + 1e-9, 5.0 - 1e-9), HISTOGRAM_EDGES)[0]
    return [int(count) for count in counts]


def failures_by_code(failures: Sequence[Failure]) -> tuple[tuple[Failure, int], ...]:
    """One example and the number of every code, the most frequent first."""
    counts = Counter(failure.code for failure in failures)
    first: dict[str, Failure] = {}
    for failure in failures:
        first.setdefault(failure.code, failure)
    return tuple((first[code], count) for code, count in counts.most_common())


def study_statistics(records: Sequence[RunRecord]) -> tuple[StudyStatistics, ...]:
    """Convergence against the size of the initial errors, in the order of the factors."""
    by_factor: dict[float, list[tuple[str, int, Failure | None]]] = {}
    for record in sorted(records, key=lambda r: r.run):
        for point in record.study:
            by_factor.setdefault(point.factor, []).append((point.outcome, point.iterations, point.failure))
    found = []
    for factor, outcomes in sorted(by_factor.items()):
        names = [name for name, _, _ in outcomes]
        iterations = [count for name, count, _ in outcomes if name != "failed"]
        failures = [failure for _, _, failure in outcomes if failure is not None]
        found.append(
            StudyStatistics(
                factor=factor,
                runs=len(outcomes),
                same=estimated_share(names.count("same"), len(names)),
                other_minimum=names.count("other minimum"),
                failed=names.count("failed"),
                iterations=float(np.median(iterations)) if iterations else float("nan"),
                failures=failures_by_code(failures),
            )
        )
    return tuple(found)
