"""Iterative data snooping (Baarda 1968; Kok 1984): the largest standardised residual beyond the critical value goes.

    reject     the observation with max |w| (or |tau|) > k, solve again from the present state, until none is beyond
    way back   a rejected observation whose predicted w = v / (sigma sqrt(1 + a Q a')) is inside k returns

Observations with a redundancy number below 0.01 are never rejected: nothing would determine their place without them.
That is also what keeps the network regular, since the variance of a rejected observation's prediction is sigma^2 / r.
An image point goes with both coordinates; a point that is left with one ray loses that, too, because nothing tells
which of two rays is wrong; arcs and tangents go with the measured point at which they end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.critical_values import critical_value
from splinebba_cli.core.revision.observation_list import ObservationList
from splinebba_cli.core.revision.revision_log import RevisionLog
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.settings import LocalTesting, OutlierPolicy

RETURNS = 1  # times that an observation may come back: it does not go round in circles
NOT_FOLLOWED = "the network could not be solved without it"
RETURNED = "its prediction fits"


@dataclass(frozen=True)
class Snooping:
    """Where data snooping ended."""

    solution: WeightedSolution
    rounds: int
    stopped: str = ""  # "share" or "rounds" where something beyond the critical value was left


@dataclass
class _Run:
    network: WeightedNetwork
    policy: OutlierPolicy
    testing: LocalTesting
    log: RevisionLog
    barred: BoolArray  # (N,) not to be rejected: what the network cannot do without
    returns: IntArray  # (N,) how often an observation has come back
    allowed: int  # number of rejections

    def beyond(self, now: WeightedSolution) -> tuple[FloatArray, IntArray]:
        """Statistics (N,) and the candidates for rejection, the worst first."""
        statistic = now.statistics.largest(self.testing.statistic)
        candidate = (now.factor > 0.0) & ~self.barred & (statistic > self.critical(now))
        order = np.argsort(-statistic, kind="stable")
        return statistic, order[candidate[order]]

    def critical(self, now: WeightedSolution) -> float:
        return critical_value(self.testing, now.statistics.tests, now.statistics.redundancy)

    def rejected_from(self, now: WeightedSolution, round_: int) -> WeightedSolution:
        """The solution without the worst observations, or the same where there is none: these are then barred."""
        statistic, candidates = self.beyond(now)
        chosen = apart(self.network.listed, candidates, self.policy.at_once)
        followers, reasons = companions(self.network.listed, now.factor > 0.0, chosen)
        gone = np.concatenate([chosen, followers])
        factor = now.factor.copy()
        factor[gone] = 0.0
        name, k = self.testing.statistic, self.critical(now)
        reasons = [f"{name} = {statistic[n]:.2f} beyond {k:.2f}" for n in chosen] + reasons
        self.log.reject(gone, round_, reasons, statistic[gone])
        then = self.network.solve(factor, now.state)
        if then is not None:
            return then
        self.log.give_back(gone, NOT_FOLLOWED)
        self.barred[chosen] = True
        return now

    def returning(self, now: WeightedSolution) -> IntArray:
        """Rejected observations whose prediction is inside the critical value, with what hangs on them."""
        rejected = self.log.rejected() & (self.returns < RETURNS)
        statistic = now.statistics.largest(self.testing.statistic)
        testable = np.isfinite(now.statistics.standardized).any(axis=1)
        inside = rejected & testable & (statistic <= self.critical(now))
        out = now.factor == 0.0
        held_back = inside & self.network.listed.orphans(out & ~inside)
        inside &= ~held_back
        used = (now.factor > 0.0) | inside
        return np.flatnonzero(inside & ~self.network.listed.unlocated(used))

    def returned_to(self, now: WeightedSolution, back: IntArray) -> WeightedSolution:
        factor = now.factor.copy()
        factor[back] = 1.0
        self.returns[back] += 1
        then = self.network.solve(factor, now.state)
        if then is None:
            return now
        self.log.give_back(back, RETURNED)
        return then


def snoop(
    network: WeightedNetwork,
    start: WeightedSolution,
    policy: OutlierPolicy,
    testing: LocalTesting,
    log: RevisionLog,
) -> Snooping:
    """Reject and bring back until nothing changes.

    Parameters
    ----------
    start : a solution; factors of 0 that are not in the log are the user's and stay
    log : is written on; what stands in it as rejected may return
    """
    taking_part = int((start.factor > 0.0).sum()) + log.count()
    run = _Run(
        network,
        policy,
        testing,
        log,
        barred=np.zeros(len(network.listed), dtype=bool),
        returns=np.zeros(len(network.listed), dtype=np.int64),
        allowed=max(int(policy.max_share * taking_part), log.count()),
    )
    now, round_ = start, 0
    while True:
        if len(run.beyond(now)[1]):
            if log.count() >= run.allowed:
                back = run.returning(now)
                if not len(back):
                    return Snooping(now, round_, "share")
                now = run.returned_to(now, back)
                continue
            if round_ >= policy.max_rounds:
                return Snooping(now, round_, "rounds")
            round_ += 1
            now = run.rejected_from(now, round_)
            continue
        back = run.returning(now)
        if not len(back):
            return Snooping(now, round_)
        now = run.returned_to(now, back)


def apart(listed: ObservationList, candidates: IntArray, number: int) -> IntArray:
    """The first `number` candidates of different images and different features."""
    images: set[int] = set()
    features: set[int] = set()
    chosen: list[int] = []
    for n in candidates.tolist():
        image, feature = int(listed.image[n]), int(listed.feature[n])
        if image in images or feature in features:
            continue
        chosen.append(n)
        images.add(image)
        features.add(feature)
        if len(chosen) == number:
            break
    return np.array(chosen, dtype=np.int64)


def companions(listed: ObservationList, used: BoolArray, gone: IntArray) -> tuple[IntArray, list[str]]:
    """Observations that cannot stay without those that go, and why."""
    without = used.copy()
    without[gone] = False
    orphans = np.flatnonzero(listed.orphans(~without) & without)
    without[orphans] = False
    single = np.flatnonzero(listed.unlocated(without))
    reasons = ["its measured point is rejected"] * len(orphans)
    reasons += ["the last ray of a point does not locate it"] * len(single)
    return np.concatenate([orphans, single]), reasons
