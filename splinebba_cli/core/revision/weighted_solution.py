"""Solutions of one network with changing weights, each from the state of the last one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.gauss_markov import STATIONARY, Observer, Solution, solution_at, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.revision.local_statistics import LocalStatistics, local_statistics
from splinebba_cli.core.revision.observation_list import ObservationList
from splinebba_cli.core.revision.observation_weights import faintly_weighted
from splinebba_cli.core.state import Prepared, State

CURVE_DAMPING = 1e-3  # starting value of the Levenberg-Marquardt factor
PATIENCE = 2


@dataclass(frozen=True)
class WeightedSolution:
    """A converged solution, the factors of the weights that it had, and the residuals."""

    factor: FloatArray  # (N,)
    solved: ConditionedSolution
    statistics: LocalStatistics

    @property
    def state(self) -> State:
        """The adjusted state."""
        return self.solved.solution.state


class WeightedNetwork:
    """All measurements of a network with the same unknowns and gauge conditions, to be solved with any weights."""

    def __init__(
        self,
        prepared: Prepared,
        state: State,
        conditions: IntArray | None,
        observer: Observer | None,
        stage: str = "outliers",
        sliding: float = 1.0,
    ) -> None:
        """All of a network.

        Parameters
        ----------
        prepared : all measurements with their given sigma
        conditions : gauge conditions that are kept; None keeps all of them
        sliding : factor of the sigma of gauge conditions: how far knots may slide along their curves
        """
        settings = prepared.network.settings
        layout = datum_layout(prepared, state)
        gauge = gauge_rows(prepared, layout.coefficient_mask, settings.gauge_sigma_m)
        gauge = gauge.with_sigma_times(sliding)
        self.conditions = np.arange(len(gauge)) if conditions is None else conditions
        control = control_rows(prepared, layout.coefficient_mask)
        rows = concatenate_rows([control, gauge.select(self.conditions)], prepared.curves.support)
        self.prepared = prepared
        self.listed = ObservationList.of(prepared.network)
        self.observer = observer
        self.stage = stage
        self._assembler = Assembler(prepared, layout, rows)
        self._noise = (
            1.0  # sigma0 of the last solution: with gross errors in it, steps are measured by what it shows
        )

    def iterate(self, factor: FloatArray, state: State, iterations: int, damping: float) -> Solution:
        """At most so many iterations with the factors (N,) of the weights.

        Raises
        ------
        FloatingPointError
            If the state puts something behind a camera.
        """
        assembler = self._assembler.with_weights(faintly_weighted(self.prepared, self.listed, factor))
        solution = solve(
            assembler,
            state,
            max_iterations=iterations,
            stage=self.stage,
            damping=damping,
            observer=self.observer,
            stationary=STATIONARY * self._noise,
        )
        self._assembler = assembler  # with the pattern that it has grown
        return solution

    def _converged(self, factor: FloatArray, state: State) -> Solution | None:
        """Gauss-Newton steps from the state; where these do not settle, damped ones with more patience."""
        limit = self.prepared.network.settings.max_iterations
        for iterations, damping in ((limit, 0.0), (PATIENCE * limit, CURVE_DAMPING)):
            try:
                solution = self.iterate(factor, state, iterations, damping)
            except (FloatingPointError, np.linalg.LinAlgError):
                continue
            if solution.converged:
                return solution
        return None

    def solve(self, factor: FloatArray, state: State) -> WeightedSolution | None:
        """The solution with the factors (N,) of the weights; None where there is none."""
        solution = self._converged(factor, state)
        return None if solution is None else self._judged(factor, solution)

    def known(self, factor: FloatArray, state: State) -> WeightedSolution | None:
        """The same where the state is known to be the solution with these factors; None where it is singular."""
        weighted = faintly_weighted(self.prepared, self.listed, factor)
        self._assembler = self._assembler.with_weights(weighted)
        try:
            solution = solution_at(self._assembler, state)
        except (FloatingPointError, np.linalg.LinAlgError):
            return None
        return self._judged(factor, solution) if solution.converged else None

    def _judged(self, factor: FloatArray, solution: Solution) -> WeightedSolution:
        solved = ConditionedSolution(self._assembler, solution, self.conditions)
        statistics = local_statistics(self.listed, factor, solved)
        self._noise = max(1.0, statistics.sigma0)
        return WeightedSolution(factor, solved, statistics)
