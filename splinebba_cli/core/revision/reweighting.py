"""Robust estimation by iteratively reweighted least squares, the state carried over from solution to solution.

    p_i = f(u_i),   u_i = v_i / (s sigma_i sqrt(q_i))

with q the cofactor of the residual under the present weights (:mod:`~.local_statistics`), so that a measurement is
judged by what its residual shows of it.  s = 1 where sigma0 is known (statistic w), else 1.4826 median |u|.  Points get
one weight for both coordinates, points on curves one by their residual across.  The last adjustment keeps the weights;
what has less than a thousandth is rejected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.revision.data_snooping import companions
from splinebba_cli.core.revision.local_statistics import LocalStatistics
from splinebba_cli.core.revision.observation_list import POINTS, ObservationList
from splinebba_cli.core.revision.revision_log import RevisionLog
from splinebba_cli.core.revision.robust_weights import WEIGHT_FUNCTIONS, radial
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.settings import TestStatistic

SETTLED = 1e-3  # largest change of a weight
REJECTED = 1e-3  # weight below which a measurement takes no part
MAD_TO_SIGMA = 1.4826  # of a normal distribution (Hampel 1974)


@dataclass(frozen=True)
class Reweighting:
    """Where the iterations of the weights ended."""

    solution: WeightedSolution
    rounds: int
    settled: bool


def reweight(
    network: WeightedNetwork,
    start: WeightedSolution,
    method: str,
    max_rounds: int,
    statistic: TestStatistic,
    log: RevisionLog,
) -> Reweighting:
    """Iterate the weights of one of :data:`WEIGHT_FUNCTIONS` until none changes by more than a thousandth.

    Parameters
    ----------
    start : factors of 0 that are not in the log are the user's and stay; all others are weighted
    """
    barred = (start.factor == 0.0) & ~log.rejected()
    log.give_back(np.flatnonzero(log.rejected()), "weighted by its residual")
    now, rounds, settled = start, 0, False
    for rounds in range(1, max_rounds + 1):  # noqa: B007 — the count is reported
        factor = WEIGHT_FUNCTIONS[method](one_value(network.listed, now.statistics, statistic))
        factor[barred] = 0.0
        settled = bool(np.abs(factor - now.factor).max(initial=0.0) <= SETTLED)
        if settled:
            break
        then = network.solve(factor, now.state)
        if then is None:
            break
        now = then
    return Reweighting(_without_the_faint(network, now, method, statistic, rounds, log), rounds, settled)


def one_value(listed: ObservationList, statistics: LocalStatistics, statistic: TestStatistic) -> FloatArray:
    """u of every entry, (N,); what is not testable has 0 and keeps its full weight."""
    u = np.nan_to_num(np.abs(statistics.standardized)).max(axis=1, initial=0.0)
    points = slice(int(listed.starts[POINTS]), int(listed.starts[POINTS + 1]))
    u[points] = radial(statistics.standardized[points])
    if statistic == "tau":
        known = u[u > 0.0]
        scale = MAD_TO_SIGMA * float(np.median(known)) if len(known) else 1.0
        u /= max(scale, 1e-12)
    return np.asarray(u)


def _without_the_faint(
    network: WeightedNetwork,
    now: WeightedSolution,
    method: str,
    statistic: TestStatistic,
    round_: int,
    log: RevisionLog,
) -> WeightedSolution:
    """The solution without what has hardly a weight left; these are rejections."""
    faint = np.flatnonzero((now.factor > 0.0) & (now.factor < REJECTED))
    zero = np.flatnonzero((now.factor == 0.0) & (one_value(network.listed, now.statistics, statistic) > 0.0))
    zero = zero[~network.listed.excluded()[zero]]
    gone = np.union1d(faint, zero)
    if not len(gone):
        return now
    followers, reasons = companions(network.listed, now.factor > 0.0, gone)
    own = [f"weight {now.factor[n]:.1g} of {method}" for n in gone]
    every = np.concatenate([gone, followers])
    factor = now.factor.copy()
    factor[every] = 0.0
    then = network.solve(factor, now.state)
    if then is None:
        return now
    value = now.statistics.largest(statistic)
    log.reject(every, round_, own + reasons, value[every])
    return then
