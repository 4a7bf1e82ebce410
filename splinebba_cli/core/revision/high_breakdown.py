"""A start that many gross errors do not spoil, for data snooping or a reweighted adjustment to go on from.

Orientations first (:mod:`~.robust_orientation`), then everything together, both with a shrinking scale
(:mod:`~.graduated_weights`).  At the end everything beyond the critical value in its own standardised residual is taken
out; what fits in the end returns by the way back of data snooping.  Same input, same result.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.critical_values import critical_value
from splinebba_cli.core.revision.curve_restarts import restarted
from splinebba_cli.core.revision.data_snooping import companions
from splinebba_cli.core.revision.graduated_weights import graduated, settled
from splinebba_cli.core.revision.revision_log import RevisionLog
from splinebba_cli.core.revision.reweighting import MAD_TO_SIGMA, one_value
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.state import Prepared, State

# of the sigma of gauge conditions: knots that slide far make hairpins to reach gross errors with; knots that are held
# cannot make up for approximate values that are badly spaced
SLIDING = (0.003, 1.0)
FAR_OUT = 0.2  # weight of a residual of 1.1 times the scale: out where there is no solution to judge it by


@dataclass(frozen=True)
class HighBreakdownStart:
    """A state near the solution without the gross errors, and the weights 0 and 1 that go with it."""

    state: State
    factor: FloatArray  # (N,)
    solved: bool  # whether the weighted network has a solution, and the state is it


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
    ways = SLIDING if prepared.network.curves else SLIDING[:1]
    ends = [_narrowed(network, state, excluded, sliding) for sliding in ways]
    _, factor, state = min(ends, key=lambda end: end[0])
    found = network.solve(factor, state)
    if found is None:
        gone = np.flatnonzero((factor < FAR_OUT) & (excluded > 0.0))
        value = np.full(len(factor), np.nan)
        own = [f"high-breakdown start: weight {factor[n]:.1g}" for n in gone]
    else:
        state = found.state
        gone, value, own = _beyond(network, found, excluded)
    followers, reasons = companions(network.listed, excluded > 0.0, gone)
    every = np.concatenate([gone, followers])
    kept = excluded.copy()
    kept[every] = 0.0
    log.reject(every, 0, own + reasons, value[every])
    return HighBreakdownStart(state, kept, found is not None)


def _narrowed(
    network: WeightedNetwork, state: State, excluded: FloatArray, sliding: float
) -> tuple[float, FloatArray, State]:
    """Robust cost, weights (N,) and state when the scale has come down, knots held from sliding on the way."""
    prepared = network.prepared
    held = WeightedNetwork(prepared, state, None, network.observer, network.stage, sliding)
    factor, after = graduated(held, state, excluded)
    if prepared.network.curves:
        try:
            factor, after = restarted(prepared, held.listed, state, after, excluded, sliding)
        except FloatingPointError:  # as behind a camera: what is left judges by its weights
            return np.inf, factor, after
    return settled(network, after, factor, excluded)


def _beyond(
    network: WeightedNetwork, found: WeightedSolution, excluded: FloatArray
) -> tuple[IntArray, FloatArray, list[str]]:
    """What is beyond the critical value, the values of all (N,), and the reasons.

    Where most residuals are larger than their sigma allow, the limit grows with their median.
    """
    testing = network.prepared.network.settings.testing
    value = one_value(network.listed, found.statistics, "w")
    taking_part = value[excluded > 0.0]
    misfit = max(1.0, MAD_TO_SIGMA * float(np.median(taking_part))) if len(taking_part) else 1.0
    critical = misfit * critical_value(
        replace(testing, statistic="w"), found.statistics.tests, found.statistics.redundancy
    )
    gone = np.flatnonzero((value > critical) & (excluded > 0.0))
    return gone, value, [f"high-breakdown start: w = {value[n]:.1f} beyond {critical:.2f}" for n in gone]
