"""Variance components: the sigma of every group of observations estimated from the residuals, by iteration.

    sigma_g <- sigma_g s_g^1/2,   s = M^-1 c   (group_variances.py),   adjust again,   until s = 1

At the end c_g = v_g'P_g v_g = r_g in every group: Foerstner's and Helmert's estimates are then the same, and that of
restricted maximum likelihood.  The end does not depend on the sigma at the start, only on their ratios inside of a
group.  Groups whose sigma cannot be told from their few residuals keep it: f_g < 5 is a sigma known to 32 % at best;
f_g of the weights, not of the residuals, or groups would be chosen by their errors.
(Helmert 1907; Foerstner 1979; Koch 1999, section 3.6)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.component_tests import FREEDOM_NEEDED
from splinebba_cli.core.quality.group_sums import group_sums
from splinebba_cli.core.quality.group_variances import GroupVariances, group_variances
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.model_evidence import AS_GIVEN, WeightFactors
from splinebba_cli.core.quality.observation_groups import ObservationGroup, observation_groups
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Problem
from splinebba_cli.core.revision.group_weights import with_factors
from splinebba_cli.core.state import Prepared, State, prepare

SETTLED = 1e-3  # change of a factor in units of its standard deviation
LARGEST_STEP = 10.0  # of a factor in one round

Solve = Callable[[Prepared, State], ConditionedSolution]


@dataclass(frozen=True)
class Weighted:
    """A solution with estimated weights; `prepared.network` has the sigma that were used."""

    prepared: Prepared
    solved: ConditionedSolution
    weights: WeightFactors
    problems: tuple[Problem, ...] = ()


def estimate_weights(prepared: Prepared, solved: ConditionedSolution, solve: Solve) -> Weighted:
    """Iterate weights and solution, where the settings ask for it.

    Parameters
    ----------
    solve : solves a network from a state, everything together
    """
    settings = prepared.network.settings.weights
    if not settings.variance_components:
        return Weighted(prepared, solved, AS_GIVEN)
    groups = observation_groups(prepared.network)
    run = _Run(prepared, solved, np.ones(len(groups)), np.ones(len(groups), dtype=bool))
    for _ in range(settings.max_rounds):
        found = _variances(run.solved)
        run = run.without(run.free & (found.at_best < FREEDOM_NEEDED))
        if run.settled(found):
            return run.ended(groups, found.at_best, settled=True)
        moved = run.moved(found, solve)
        if moved is None:
            break
        run = moved
    return run.ended(groups, _variances(run.solved).at_best, settled=False)


@dataclass(frozen=True)
class _Run:
    start: Prepared  # with the given sigma
    solved: ConditionedSolution
    factor: FloatArray  # (G,)
    free: BoolArray  # (G,) estimated

    @property
    def prepared(self) -> Prepared:
        return self.solved.assembler.prepared

    def without(self, weak: BoolArray) -> _Run:
        """Groups that turn out too weak keep the given sigma from now on."""
        return replace(self, free=self.free & ~weak)

    def settled(self, found: GroupVariances) -> bool:
        """Whether all factors stand, and those of groups that are left out are 1."""
        sigma = found.sigma / np.sqrt(2.0 * np.maximum(found.freedom, 1e-300))
        change = np.abs(found.sigma - 1.0) / sigma
        return bool((change[self.free] <= SETTLED).all() and (self.factor[~self.free] == 1.0).all())

    def moved(self, found: GroupVariances, solve: Solve) -> _Run | None:
        """The next solution; None where there is none."""
        step = np.clip(found.sigma, 1.0 / LARGEST_STEP, LARGEST_STEP)
        factor = np.where(self.free, self.factor * step, 1.0)
        prepared = prepare(with_factors(self.start.network, factor))
        solved = solve(prepared, self.solved.solution.state)
        return replace(self, solved=solved, factor=factor) if solved.solution.converged else None

    def ended(self, groups: tuple[ObservationGroup, ...], freedom: FloatArray, *, settled: bool) -> Weighted:
        """Solution, factors and what a person should know of them."""
        weights = WeightFactors(tuple(self.factor.tolist()), tuple(self.free.tolist()))
        problems = _kept(groups, self.free, freedom) + ([] if settled else [_unsettled()])
        return Weighted(self.prepared, self.solved, weights, tuple(problems))


def _variances(solved: ConditionedSolution) -> GroupVariances:
    cofactors = Cofactors(solved.assembler, solved.solution)
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    projector = ResidualProjector(solved.assembler, solved.solution)
    groups = observation_groups(solved.assembler.prepared.network)
    return group_variances(projector, group_sums(projector, numbers, groups))


def _kept(groups: tuple[ObservationGroup, ...], free: BoolArray, freedom: FloatArray) -> list[Problem]:
    """A word on the groups that keep their sigma."""
    names = [f"`{groups[k].name}` ({freedom[k]:.1f})" for k in np.flatnonzero(~free)]
    if not names:
        return []
    message = (
        f"groups with less than {FREEDOM_NEEDED:g} degrees of freedom keep their given σ: {', '.join(names)}"
    )
    return [
        Problem("SBB552", "info", message, "variance components", "their σ rests on what is known of them")
    ]


def _unsettled() -> Problem:
    message = "the variance components have not settled; the σ of the last round are used"
    help = "look for gross errors; give groups that cannot be separated the same `name`, or state their σ"
    return Problem("SBB552", "warning", message, "variance components", help)
