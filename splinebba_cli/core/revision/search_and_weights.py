"""The search for outliers and the estimation of weights, in turn until neither changes anything.

Gross errors spoil variances, and wrong sigma make good observations look like gross errors.  So outliers are sought
first; the variances of what is left are estimated, and with these sigma the search goes on from where it stands, taking
back what now agrees.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.quality.model_evidence import AS_GIVEN, WeightFactors
from splinebba_cli.core.quality.observation_groups import observation_groups
from splinebba_cli.core.result import Problem
from splinebba_cli.core.revision.group_weights import with_factors
from splinebba_cli.core.revision.observation_list import ObservationList
from splinebba_cli.core.revision.observation_weights import reduced
from splinebba_cli.core.revision.revise import Resolve, Revised, Search, revise
from splinebba_cli.core.revision.variance_components import Weighted, estimate_weights
from splinebba_cli.core.state import Prepared

ROUNDS = 5
SETTLED = 1e-3  # of a factor of the weight


@dataclass(frozen=True)
class SearchedAndWeighted:
    """The revised solution with the weights that were estimated for what takes part."""

    revised: Revised
    weights: WeightFactors  # groups of what takes part
    problems: tuple[Problem, ...] = ()


def searched_and_weighted(
    search: Search,
    prepared: Prepared,
    solved: ConditionedSolution,
    resolve: Resolve,
    observer: Observer | None,
) -> SearchedAndWeighted:
    """Search, then estimate weights where the settings ask for it, and again while what is out changes.

    Parameters
    ----------
    prepared, solved : the joint solution of what takes part
    resolve : solves a prepared network from a state
    """
    revised = revise(search, prepared, solved, resolve, observer)
    if not prepared.network.settings.weights.variance_components:
        return SearchedAndWeighted(revised, AS_GIVEN)
    warned = (_reduced_weights(),) if prepared.network.settings.outliers.reweights else ()
    given = replace(revised.search.network, curves=revised.prepared.network.curves)
    start, weighted = revised, _weighted(revised, resolve)
    for _ in range(ROUNDS):
        factors = _by_name(start.prepared.network, weighted.weights)
        again = _searched_again(start, given, factors, weighted, resolve, observer)
        if np.abs(again.factor - start.factor).max(initial=0.0) <= SETTLED:
            start = again
            break
        start = again
        weighted = _from_given(again, given, factors, resolve)
    solution = replace(start, prepared=weighted.prepared, solved=weighted.solved)
    return SearchedAndWeighted(solution, weighted.weights, (*weighted.problems, *warned))


def _reduced_weights() -> Problem:
    message = "variance components from residuals with reduced weights are too small"
    help = "estimate σ together with `outliers: {method: snooping}`, or with none"
    return Problem("SBB552", "warning", message, "variance components", help)


Factors = dict[tuple[str, str], float]


def _weighted(revised: Revised, resolve: Resolve) -> Weighted:
    return estimate_weights(revised.prepared, revised.solved, resolve)


def _by_name(network: Network, weights: WeightFactors) -> Factors:
    """Factors of the groups by kind and name: what is out may have taken a group along."""
    groups = observation_groups(network)
    return {(g.kind, g.name): f for g, f in zip(groups, weights.factor, strict=True)}


def _factors_of(network: Network, known: Factors) -> FloatArray:
    return np.array([known.get((group.kind, group.name), 1.0) for group in observation_groups(network)])


def _searched_again(
    last: Revised,
    given: Network,
    factors: Factors,
    weighted: Weighted,
    resolve: Resolve,
    observer: Observer | None,
) -> Revised:
    """The search continued with the estimated sigma, from what it has taken out."""
    network = with_factors(given, _factors_of(given, factors))
    listed = ObservationList.of(network)
    search = replace(
        last.search,
        network=network,
        listed=listed,
        factor=last.factor,
        part=reduced(listed, last.factor, weighted.solved.solution.state.xyz),
    )
    search.log.listed = listed
    again = revise(search, weighted.prepared, weighted.solved, resolve, observer)
    return replace(again, rounds=last.rounds + again.rounds)


def _from_given(again: Revised, given: Network, factors: Factors, resolve: Resolve) -> Weighted:
    """Weights estimated for another set of observations, their factors counted from the given sigma."""
    weighted = _weighted(again, resolve)
    before = _factors_of(again.prepared.network, factors)
    factor = before * np.array(weighted.weights.factor or np.ones(len(before)))
    weights = replace(weighted.weights, factor=tuple(factor.tolist()))
    return replace(weighted, weights=weights)
