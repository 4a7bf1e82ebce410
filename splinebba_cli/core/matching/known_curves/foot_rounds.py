"""Solutions between which the foot points on held curves are sought again (held_feet.py)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import datum_layout
from splinebba_cli.core.estimation.gauss_markov import solution_at, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.matching.known_curves.held_feet import HeldPoints, feet, observed_at
from splinebba_cli.core.matching.known_curves.round_network import RoundNetwork
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows
from splinebba_cli.core.observations.shape_conditions import control_rows
from splinebba_cli.core.state import Prepared, State

CURVE_DAMPING = 1e-3
FOOT_ROUNDS = 12
SETTLED = 0.02  # sigma, of the first step of a solution: foot points that move less change nothing


@dataclass
class FootRun:
    """One network and its points on held curves, whose foot points move from solution to solution."""

    problem: RoundNetwork
    points: HeldPoints
    u: FloatArray  # (k,)
    prepared: Prepared

    def solved(self, state: State) -> ConditionedSolution | None:
        """The solution when the orientations no longer move; None where the matrix is singular."""
        state = self._moved_to_feet(state)
        layout = datum_layout(self.prepared, state)
        gauge = gauge_rows(
            self.prepared, layout.coefficient_mask, self.problem.network.settings.gauge_sigma_m
        )
        control = control_rows(self.prepared, layout.coefficient_mask)
        rows = concatenate_rows([control, gauge], self.prepared.curves.support)
        assembler = Assembler(self.prepared, layout, rows)
        damping = CURVE_DAMPING if len(gauge) else 0.0
        for _ in range(FOOT_ROUNDS if len(self.points) else 1):
            solution = solve(
                assembler, state, max_iterations=self._iterations(layout), stage="matching", damping=damping,
                observer=self.problem.observer,
            )  # fmt: skip
            state = self._moved_to_feet(solution.state)
            assembler = assembler.with_weights(self.prepared)
            if solution.iterations and solution.iterations[0].step < SETTLED:
                break
        if solution.factor is None or len(self.points):
            reached = solution_at(assembler, state)
            solution = replace(reached, termination=solution.termination)
        if solution.factor is None:
            return None
        return ConditionedSolution(assembler, solution, np.arange(len(gauge)))

    def _iterations(self, layout: ParameterLayout) -> int:
        """Of an adjustment between two searches for foot points: one where orientations are all there is."""
        alone = len(self.points) and not layout.coefficient_mask.any() and not layout.point_mask.any()
        return 1 if alone else self.problem.iterations

    def _moved_to_feet(self, state: State) -> State:
        if not len(self.points):
            return state
        found = feet(self.points, self.u, state)
        self.u, self.prepared = found.u, observed_at(self.points, found, self.prepared)
        return replace(state, xyz=np.vstack([state.xyz[: len(state.xyz) - len(self.points)], found.xyz]))
