"""Monte Carlo: do the errors of an adjustment follow the dispersion that it reports?

Over seeded runs, with e = estimated - true and D the dispersion of some elements (a priori sigma0),

    e' D^-1 e               chi-square with one degree of freedom for each estimated element
    e_i / sqrt(D_ii)        standard normal: sum of squares over N runs is chi-square with N degrees of
    freedom accepted global tests   binomial(N, 1 - alpha)

Every figure comes with the interval in which a correct program finds it with 99 % probability.  Images of a
run are correlated: figures over all images use the degrees of freedom of one, which makes their interval
wider than needed; the same holds for the places along a curve.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.intervals import (
    Figure,
    binomial_interval,
    mean_square_interval,
    ratio_interval,
    within_confidence,
)
from splinebba_cli.simulation.run_errors import reference_of_truth
from splinebba_cli.simulation.run_record import Failure, RunRecord, failed_record, solved_record
from splinebba_cli.simulation.truth import Truth

__all__ = ["Figure", "MonteCarloResult", "binomial_interval", "mean_square_interval", "run_monte_carlo"]

MakeNetwork = Callable[[int], tuple[Network, Truth]]
Adjust = Callable[[Network], AdjustmentResult]


@dataclass(frozen=True)
class MonteCarloResult:
    """Errors over the N runs that were solved; NaN where nothing is estimated."""

    runs: int  # runs asked for
    failures: int  # runs without a solution
    errors: FloatArray  # (N, m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m); NaN: not estimated
    normalized: FloatArray  # (N, m, 6) errors over their predicted sigma
    squares: FloatArray  # (N, m) e' D^-1 e of each image
    point_errors: FloatArray  # (N, n, 3) m
    point_normalized: FloatArray  # (N, n, 3)
    across: FloatArray  # (N, k, p, 2) errors of curves across, m: to the left, upwards
    across_normalized: FloatArray  # (N, k, p, 2) over the semi-axes of the lateral standard ellipse
    locations: FloatArray  # (N, q) errors of locations on curves whose every value is given, units of u
    locations_normalized: FloatArray  # (N, q)
    accepted: BoolArray  # (N,) global test, of the runs with redundancy
    sigma0: FloatArray  # (N,)
    redundancy: FloatArray  # (N,)
    alpha: float  # of the global test
    scaled: bool  # whether reported standard deviations are multiplied by sigma0

    @property
    def solved(self) -> int:
        """Number of runs with a solution."""
        return len(self.errors)

    @property
    def estimated(self) -> BoolArray:
        """Which orientation elements are estimated, (m, 6)."""
        return np.asarray(np.isfinite(self.errors).all(axis=0))

    @property
    def acceptance(self) -> Figure:
        """Share of accepted global tests; 1 - alpha is right."""
        if not len(self.accepted):
            return Figure(float("nan"), 0.0, 1.0)
        lower, upper = binomial_interval(len(self.accepted), 1.0 - self.alpha)
        return Figure(float(self.accepted.mean()), lower, upper)

    @property
    def mean_square(self) -> Figure:
        """Mean squared normalised error of an orientation element, over all images; 1 is right."""
        freedom = self.estimated.sum(axis=1)
        if not freedom.any():
            return Figure(float("nan"), 0.0, float("inf"))
        value = float(np.nansum(self.squares) / (len(self.squares) * freedom.sum()))
        return Figure(value, *mean_square_interval(len(self.squares) * int(freedom[freedom > 0].min())))

    @property
    def image_mean_squares(self) -> tuple[Figure, ...]:
        """Mean squared normalised error of the elements of each image, NaN where none is estimated."""
        figures = []
        for image, freedom in enumerate(self.estimated.sum(axis=1)):
            count = len(self.squares) * int(freedom)
            value = float(self.squares[:, image].sum() / count) if count else float("nan")
            figures.append(Figure(value, *(mean_square_interval(count) if count else (0.0, np.inf))))
        return tuple(figures)

    @property
    def sigma_ratio(self) -> FloatArray:
        """Empirical (about zero, not about the mean) over predicted standard deviation, (m, 6)."""
        return np.asarray(np.sqrt(np.mean(self.normalized**2, axis=0)))

    def sigma_ratio_interval(self, simultaneous: bool = True) -> tuple[float, float]:
        """Interval of :attr:`sigma_ratio`, for all elements together (Bonferroni) or for a single one."""
        return ratio_interval(len(self.errors), int(self.estimated.sum()) if simultaneous else 1)

    def covered(self, squares: FloatArray, freedom: FloatArray | float, confidence: float) -> FloatArray:
        """1 where the truth lies in the reported confidence region, 0 where not; NaN where there is none."""
        factor = np.where(self.scaled & (self.redundancy > 0), self.sigma0, np.nan)
        inside = within_confidence(squares, freedom, factor, self.redundancy, confidence)
        return np.where(np.isfinite(squares), inside.astype(np.float64), np.nan)


def summarize(records: Sequence[RunRecord], alpha: float, scaled: bool) -> MonteCarloResult:
    """All solved runs as arrays.

    Raises
    ------
    ValueError
        If no run was solved.
    """
    ordered = sorted(records, key=lambda record: record.run)
    solved = [(record, record.errors) for record in ordered if record.errors is not None]
    if not solved:
        raise ValueError(f"none of {len(records)} runs was solved")
    errors = [each for _, each in solved]

    def curves(name: str) -> FloatArray:
        if not errors[0].curves:
            return np.zeros((len(errors), 0, 0, 2))
        return np.array([[getattr(curve, name) for curve in run.curves] for run in errors])

    def stacked(name: str) -> FloatArray:
        return np.array([getattr(run, name) for run in errors])

    return MonteCarloResult(
        runs=len(records),
        failures=len(records) - len(solved),
        errors=stacked("eop"),
        normalized=stacked("eop_normalized"),
        squares=stacked("image_squares"),
        point_errors=stacked("points"),
        point_normalized=stacked("points_normalized"),
        across=curves("across"),
        across_normalized=curves("normalized"),
        locations=stacked("locations"),
        locations_normalized=stacked("locations_normalized"),
        accepted=np.array([r.accepted for r, _ in solved if r.accepted is not None], dtype=bool),
        sigma0=np.array([r.sigma0 for r, _ in solved]),
        redundancy=np.array([r.redundancy for r, _ in solved], dtype=np.float64),
        alpha=alpha,
        scaled=scaled,
    )


def run_monte_carlo(
    make_network: MakeNetwork,
    adjust: Adjust,
    runs: int,
    seed: int = 1,
    executor: Executor | None = None,
) -> MonteCarloResult:
    """Adjust many simulated networks and compare the errors with the reported dispersion.

    Parameters
    ----------
    make_network : called with the seed of a run; network and truth in the same local frame
    adjust : returns a result in the user's frame (local frame plus the network's origin)
    runs : number of runs; run i has the seed `seed` + i
    executor : runs them in parallel; make_network and adjust must then be picklable

    Raises
    ------
    ValueError
        If no run was solved.
    """
    seeds = range(seed, seed + runs)
    one = partial(_one_run, make_network, adjust)
    outcomes = list(map(one, seeds) if executor is None else executor.map(one, seeds))
    settings = make_network(seed)[0].settings
    return summarize(outcomes, settings.alpha, settings.scale_dispersion)


def _one_run(make_network: MakeNetwork, adjust: Adjust, seed: int) -> RunRecord:
    """The record of one run."""
    network, truth = make_network(seed)
    try:
        result = adjust(network)
    except NotSolvableError as error:
        return failed_record(seed, Failure(error.code, error.message))
    return solved_record(seed, result, reference_of_truth(network, truth))
