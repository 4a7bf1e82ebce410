"""The search for outliers around an adjustment, in order:

start       what the user has taken out; a high-breakdown start where it is asked for
search      data snooping, or a reweighted adjustment, on the joint solution
last        the network without what is out, solved once more with its gauge conditions chosen anew
predictions of what is out, against that solution
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.quality.determinacy import weak_images
from splinebba_cli.core.result import Problem
from splinebba_cli.core.revision.data_snooping import companions, snoop
from splinebba_cli.core.revision.high_breakdown import high_breakdown_start
from splinebba_cli.core.revision.observation_list import KINDS, ObservationList
from splinebba_cli.core.revision.observation_weights import Reduced, reduced
from splinebba_cli.core.revision.revision_log import RevisionLog
from splinebba_cli.core.revision.reweighting import reweight
from splinebba_cli.core.revision.robust_orientation import robust_orientation
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.settings import OutlierPolicy
from splinebba_cli.core.state import Prepared, State, prepare
from splinebba_cli.errors import NotConvergedError, SingularNetworkError

Resolve = Callable[[Prepared, State], ConditionedSolution]


@dataclass(frozen=True)
class Search:
    """What is known before the adjustment: which measurements take part."""

    network: Network  # all measurements
    listed: ObservationList
    excluded: FloatArray  # (N,) 0 where the user has taken something out, else 1
    factor: FloatArray  # (N,) with which the adjustment begins
    part: Reduced
    log: RevisionLog


@dataclass(frozen=True)
class Revised:
    """The solution to be reported, and everything that is out against it."""

    search: Search
    prepared: Prepared  # of what takes part
    solved: ConditionedSolution
    part: Reduced
    factor: FloatArray  # (N,)
    against: (
        WeightedSolution | None
    )  # all measurements, those that are out predicted; None where nothing is out
    rounds: int = 0
    stopped: str = ""  # "share", "rounds", "unsettled", "unsolved" where the search ended early


def begin_search(network: Network) -> Search:
    """The search of a network: without what the user has taken out, and what cannot stay without it."""
    listed = ObservationList.of(network)
    factor = np.where(listed.excluded(), 0.0, 1.0)
    if (factor == 0.0).any():
        followers, _ = companions(listed, factor > 0.0, np.flatnonzero(factor == 0.0))
        factor[followers] = 0.0
        network = listed.with_excluded(factor == 0.0)
        listed = ObservationList.of(network)
        part = reduced(listed, factor, network.points.xyz)
    else:
        every = [np.arange(len(listed.part(factor, kind))) for kind in range(len(KINDS))]
        part = Reduced(network, *every)
    return Search(network, listed, factor, factor, part, RevisionLog(listed))


@dataclass(frozen=True)
class RobustStart:
    """Where a high-breakdown start ends, for the adjustment to go on from."""

    search: Search  # without what it has found
    prepared: Prepared  # of what takes part
    state: State
    solved: bool  # whether the state is a solution of everything together


def robust_start(search: Search, prepared: Prepared, state: State, observer: Observer | None) -> RobustStart:
    """The search without what a high-breakdown start finds, and the state that it reaches."""
    full = prepare(search.network)
    state = robust_orientation(search.part.network, state, observer)
    everything = expanded(state, search.part, len(search.network.curve_observations))
    found = high_breakdown_start(full, everything, search.factor, search.log, observer)
    if not search.log.entries:
        return RobustStart(search, prepared, search.part.state(found.state), found.solved)
    part = reduced(search.listed, found.factor, found.state.xyz)
    return RobustStart(
        replace(search, factor=found.factor, part=part),
        prepare(part.network),
        part.state(found.state),
        found.solved,
    )


def expanded(state: State, part: Reduced, count: int) -> State:
    """A state with places for the locations of all measured points; unknown (NaN) where they take no part."""
    location = np.full(count, np.nan)
    location[part.curves] = state.location
    return replace(state, location=location)


def revise(
    search: Search,
    prepared: Prepared,
    solved: ConditionedSolution,
    resolve: Resolve,
    observer: Observer | None,
) -> Revised:
    """Search for outliers from a joint solution of what takes part.

    Parameters
    ----------
    prepared, solved : the joint solution; its knots may be others than those of the project
    resolve : solves a prepared network from a state, gauge conditions chosen anew
    """
    policy = prepared.network.settings.outliers
    out = (search.factor == 0.0).any()
    unchanged = Revised(search, prepared, solved, search.part, search.factor, None)
    if policy.method == "none" and not out:
        return unchanged
    network = replace(search.network, curves=prepared.network.curves)
    listed = ObservationList.of(network)
    search = replace(search, network=network, listed=listed)
    search.log.listed = listed
    state = expanded(solved.solution.state, search.part, len(network.curve_observations))
    everything, now = _of_everything(network, state, solved, search.factor, observer)
    if now is None:
        if out:
            raise NotConvergedError([_UNPREDICTED])
        return replace(unchanged, stopped="unsolved")
    unchanged = replace(unchanged, search=search, against=now)
    now, rounds, stopped = _searched(everything, now, policy, search)
    return _last(search, everything, now, resolve, unchanged, rounds, stopped)


_UNPREDICTED = Problem(
    "SBB543",
    "error",
    "the network was solved without the observations that are out, but these could not be predicted from it",
    "outliers",
    "give the splines fewer knots or better approximate values, or `adjustment.gauge_conditions: all`",
)


def _of_everything(
    network: Network, state: State, solved: ConditionedSolution, factor: FloatArray, observer: Observer | None
) -> tuple[WeightedNetwork, WeightedSolution | None]:
    """All measurements with their weights at a joint solution of those that take part.

    It is their solution, too: where the iterations, begun again there, do not settle, it stands as it is.
    """
    everything = WeightedNetwork(prepare(network), state, solved.conditions, observer)
    return everything, everything.solve(factor, state) or everything.known(factor, state)


def _searched(
    everything: WeightedNetwork, now: WeightedSolution, policy: OutlierPolicy, search: Search
) -> tuple[WeightedSolution, int, str]:
    """The solution after the method of the policy, the number of rounds, and why it ended early."""
    testing = everything.prepared.network.settings.testing
    if policy.method == "none":
        return now, 0, ""
    if policy.method == "snooping":
        snooped = snoop(everything, now, policy, testing, search.log)
        return snooped.solution, snooped.rounds, snooped.stopped
    found = reweight(everything, now, policy.method, policy.max_rounds, testing.statistic, search.log)
    return found.solution, found.rounds, "" if found.settled else "unsettled"


def _last(
    search: Search,
    everything: WeightedNetwork,
    now: WeightedSolution,
    resolve: Resolve,
    unchanged: Revised,
    rounds: int,
    stopped: str,
) -> Revised:
    """The reported solution: rows that are out left out, and predicted against it."""
    if np.array_equal(now.factor, search.factor):
        part, prepared, solved = search.part, unchanged.prepared, unchanged.solved
    else:
        part = reduced(search.listed, now.factor, now.state.xyz)
        prepared = prepare(part.network)
        again = _resolved(prepared, part.state(now.state), resolve)
        if again is None:
            found = search.log.rejected() & (search.factor > 0.0)
            search.log.give_back(np.flatnonzero(found), "the network was not solved without all of these")
            return replace(unchanged, rounds=rounds, stopped="unsolved")
        solved = again
    against = None
    if (now.factor == 0.0).any() or search.log.entries:
        count = len(search.network.curve_observations)
        state = expanded(solved.solution.state, part, count)
        last = WeightedNetwork(
            everything.prepared, state, solved.conditions, everything.observer, "predictions"
        )
        against = last.solve(now.factor, state) or now
    return Revised(search, prepared, solved, part, now.factor, against, rounds, stopped)


def _resolved(prepared: Prepared, state: State, resolve: Resolve) -> ConditionedSolution | None:
    try:
        solved = resolve(prepared, state)
    except (FloatingPointError, SingularNetworkError, np.linalg.LinAlgError):
        return None
    return solved if solved.solution.converged and not weak_images(prepared, solved) else None
