"""A start that many gross errors do not spoil: a redescending estimator whose scale shrinks.

Weights of Geman and McClure (1987) for residuals r over sigma and a scale s,

    p = 1 / (1 + (r / s)^2)^2,

begin with s so wide that the cost is nearly that of least squares and shrink it by a third from step to step
(graduated non-convexity, Blake and Zisserman 1987), never below a multiple of the median of |r|, down to three
sigma.  Errors of the approximate values are larger than gross errors at first, but common to many points: they go
while the scale is wide.  The median breaks down at one half.  At the end everything beyond the critical value in its
own standardised residual is taken out; data snooping or a reweighted adjustment go on from there, and what fits then
returns.

Nothing is drawn at random: same input, same result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Observer, Solution
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import critical_value
from splinebba_cli.core.revision.data_snooping import companions
from splinebba_cli.core.revision.observation_list import CURVES, ObservationList
from splinebba_cli.core.revision.observation_weights import FAINT
from splinebba_cli.core.revision.revision_log import RevisionLog
from splinebba_cli.core.revision.reweighting import MAD_TO_SIGMA, one_value
from splinebba_cli.core.revision.weighted_solution import CURVE_DAMPING, WeightedNetwork
from splinebba_cli.core.state import Prepared, State

WIDE = 4.0  # times the median residual of the start
SHRINKING = 0.67  # a step
NARROW = 3.0  # sigma: the last scale
ABOVE_MEDIAN = 1.5  # times the median residual: the scale does not outrun the convergence
STEPS = 60
STALLS = 3  # steps without a smaller scale that end it
ITERATIONS = 2  # of the adjustment a step


@dataclass(frozen=True)
class HighBreakdownStart:
    """A state near the solution without the gross errors, and the weights 0 and 1 that go with it."""

    state: State
    factor: FloatArray  # (N,)


def high_breakdown_start(
    prepared: Prepared, state: State, excluded: FloatArray, log: RevisionLog, observer: Observer | None
) -> HighBreakdownStart:
    """Weights and state from approximate values.

    Parameters
    ----------
    prepared : of all measurements, with their given sigma
    excluded : (N,) factors 1 and 0; what is 0 stays out
    log : is written on
    """
    network = WeightedNetwork(prepared, state, None, observer, "start")
    factor, state = _graduated(network, state, excluded)
    found = network.solve(factor, state)
    if found is None:
        return HighBreakdownStart(state, excluded)
    testing = prepared.network.settings.testing
    value = one_value(network.listed, found.statistics, "w")
    misfit = max(1.0, float(np.sqrt(_median_square(value[excluded > 0.0]))))
    critical = misfit * critical_value(
        replace(testing, statistic="w"), found.statistics.tests, found.statistics.redundancy
    )
    gone = np.flatnonzero((value > critical) & (excluded > 0.0))
    followers, reasons = companions(network.listed, excluded > 0.0, gone)
    every = np.concatenate([gone, followers])
    kept = excluded.copy()
    kept[every] = 0.0
    own = [f"high-breakdown start: w = {value[n]:.1f} beyond {critical:.2f}" for n in gone]
    log.reject(every, 0, own + reasons, value[every])
    return HighBreakdownStart(found.state, kept)


def _median_square(value: FloatArray) -> float:
    return (MAD_TO_SIGMA * float(np.median(value))) ** 2 if len(value) else 1.0


def _graduated(network: WeightedNetwork, state: State, excluded: FloatArray) -> tuple[FloatArray, State]:
    """Weights and state when the scale has come down."""
    factor, scale, stalls = excluded, np.inf, 0
    for _ in range(STEPS):
        try:
            solution = network.iterate(factor, state, ITERATIONS, CURVE_DAMPING)
        except (FloatingPointError, np.linalg.LinAlgError):
            break
        state = solution.state
        r = residual_size(network.listed, solution, factor)
        median = MAD_TO_SIGMA * float(np.median(r[excluded > 0.0]))
        before = scale
        scale = max(NARROW, ABOVE_MEDIAN * median, min(SHRINKING * scale, WIDE * median))
        factor = excluded / (1.0 + (r / scale) ** 2) ** 2
        stalls = stalls + 1 if scale >= 0.99 * before else 0
        if stalls == STALLS:
            break
    return factor, state


def residual_size(listed: ObservationList, solution: Solution, factor: FloatArray) -> FloatArray:
    """|r| over the given sigma of every entry, (N,): of one coordinate of a point, across curves."""
    at = solution.linearization
    whitened = np.zeros(len(listed))
    whitened[: len(at.points.residual)] = np.sqrt(0.5 * np.sum(at.points.residual**2, axis=1))
    count = len(at.curve.speed)
    listed.part(whitened, CURVES)[:] = np.abs(at.curve.residual[:count])
    whitened[listed.starts[CURVES + 1] :] = np.abs(
        np.concatenate([at.linked.arc_residual, at.linked.tangent_residual])
    )
    return np.asarray(whitened / np.sqrt(np.maximum(factor, FAINT)))
