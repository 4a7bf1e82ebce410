"""Monte Carlo: do the errors of an adjustment follow the dispersion that it reports?

Over seeded runs, with e = estimated - true and D the 6 x 6 dispersion of one image (a priori sigma0),

    e' D^-1 e               chi-square with one degree of freedom for each estimated element
    e_i / sqrt(D_ii)        standard normal: sum of squares over N runs is chi-square with N degrees of
    freedom accepted global tests   binomial(N, 1 - alpha)

Every figure comes with the interval in which a correct program finds it with 99 % probability.  Images of a
run are correlated: figures over all images use the degrees of freedom of one, which makes their interval
wider than needed.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import bdtr, chdtri

from splinebba_cli.core.camera.rotation import wrap_angle
from splinebba_cli.core.network import BoolArray, FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.simulation.truth import Truth

CONFIDENCE = 0.99

MakeNetwork = Callable[[int], tuple[Network, Truth]]
Adjust = Callable[[Network], AdjustmentResult]


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


@dataclass(frozen=True)
class MonteCarloResult:
    """Errors of the exterior orientations over N runs that were solved."""

    runs: int  # runs asked for
    failures: int  # runs without a solution
    errors: FloatArray  # (N, m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m); NaN: not estimated
    normalized: FloatArray  # (N, m, 6) errors over their predicted sigma
    squares: FloatArray  # (N, m) e' D^-1 e of each image
    estimated: BoolArray  # (m, 6)
    accepted: BoolArray  # (N,) global test
    sigma0: FloatArray  # (N,)
    alpha: float  # of the global test

    @property
    def acceptance(self) -> Figure:
        """Share of accepted global tests; 1 - alpha is right."""
        lower, upper = binomial_interval(len(self.accepted), 1.0 - self.alpha)
        return Figure(float(self.accepted.mean()), lower, upper)

    @property
    def mean_square(self) -> Figure:
        """Mean squared normalised error of an orientation element, over all images; 1 is right."""
        freedom = self.estimated.sum(axis=1)
        value = float(self.squares.sum() / (len(self.squares) * freedom.sum()))
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
        elements = int(self.estimated.sum()) if simultaneous else 1
        lower, upper = mean_square_interval(len(self.errors), 1.0 - (1.0 - CONFIDENCE) / max(elements, 1))
        return float(np.sqrt(lower)), float(np.sqrt(upper))


def mean_square_interval(freedom: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Two-sided interval of chi-square over its degrees of freedom."""
    tail = 0.5 * (1.0 - confidence)
    return float(chdtri(freedom, 1.0 - tail)) / freedom, float(chdtri(freedom, tail)) / freedom


def binomial_interval(count: int, probability: float, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Shares between which a binomial variable lies with at least the given probability."""
    tail = 0.5 * (1.0 - confidence)
    below = bdtr(np.arange(count + 1.0), count, probability)  # P(successes <= k)
    lower = int(np.searchsorted(below, tail, side="right"))
    upper = int(np.searchsorted(below, 1.0 - tail, side="left"))
    return lower / count, min(upper, count) / count


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
    solved = [outcome for outcome in outcomes if outcome is not None]
    if not solved:
        raise ValueError(f"none of {runs} runs was solved")
    return MonteCarloResult(
        runs=runs,
        failures=runs - len(solved),
        errors=np.array([run.errors for run in solved]),
        normalized=np.array([run.normalized for run in solved]),
        squares=np.array([run.squares for run in solved]),
        estimated=solved[0].estimated,
        accepted=np.array([run.accepted for run in solved], dtype=bool),
        sigma0=np.array([run.sigma0 for run in solved]),
        alpha=solved[0].alpha,
    )


@dataclass(frozen=True)
class _Run:
    errors: FloatArray  # (m, 6)
    normalized: FloatArray  # (m, 6)
    squares: FloatArray  # (m,)
    estimated: BoolArray  # (m, 6)
    accepted: bool
    sigma0: float
    alpha: float


def _one_run(make_network: MakeNetwork, adjust: Adjust, seed: int) -> _Run | None:
    """Errors of one run; None where the adjustment found no solution."""
    network, truth = make_network(seed)
    try:
        result = adjust(network)
    except NotSolvableError:
        return None
    test = result.statistics.global_test
    if test is None:
        raise ValueError("a Monte Carlo run needs a network with redundancy")
    images = result.images
    errors = images.eop - truth.eop
    errors[:, 3:] -= network.origin
    errors[:, :3] = wrap_angle(errors[:, :3])
    dispersion = _prior_dispersion(result)
    squares = np.zeros(len(errors))
    for i, free in enumerate(images.estimated):
        if free.any():
            e = errors[i, free]
            squares[i] = e @ np.linalg.solve(dispersion[i][np.ix_(free, free)], e)
    with np.errstate(invalid="ignore", divide="ignore"):
        normalized = errors / np.sqrt(np.diagonal(dispersion, axis1=1, axis2=2))
    return _Run(
        errors=np.where(images.estimated, errors, np.nan),
        normalized=np.where(images.estimated, normalized, np.nan),
        squares=squares,
        estimated=images.estimated,
        accepted=test.passed,
        sigma0=result.statistics.sigma0,
        alpha=test.alpha,
    )


def _prior_dispersion(result: AdjustmentResult) -> FloatArray:
    """Dispersion of the orientations by the a priori sigma0, (m, 6, 6), free of the scatter of sigma0."""
    statistics = result.statistics
    if not result.network.settings.scale_dispersion:
        return result.images.dispersion
    return np.asarray(result.images.dispersion * (statistics.sigma0_prior / statistics.sigma0) ** 2)
