"""A solution with no more gauge conditions than needed (see gauge.py)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, TIGHT
from splinebba_cli.core.estimation.gauge import jointly_needed, needed_conditions
from splinebba_cli.core.estimation.gauss_markov import Observer, Solution, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.estimation.stretches import Stretches
from splinebba_cli.core.estimation.window_map import WindowMap
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows, concatenate_rows
from splinebba_cli.core.state import Prepared, State

ROUNDS = 8
SHARES = (0.5, 0.1, 0.02, 0.0)  # of the worst stretch, each time that conditions come back
UNSETTLED = 0.1  # of the estimated variance: recent changes of the squares of a stretch that goes on moving


@dataclass(frozen=True)
class ConditionedSolution:
    """Solution, the equations that it took, and which of the conditions it needed."""

    assembler: Assembler
    solution: Solution
    conditions: IntArray  # conditions that took part, numbers in the list of all


def leverage_of(rows: CoefficientRows, assembler: Assembler, solution: Solution) -> FloatArray:
    """g Q g' of rows at a solution, (q,)."""
    if solution.factor is None or not len(rows):
        return np.zeros(len(rows))
    values = solution.factor.selected_inverse().values
    window = WindowMap.of(assembler.structure, assembler.slots_of_columns(rows.columns))
    mask = assembler.layout.coefficient_mask[rows.columns].reshape(len(rows), -1)
    j = rows.jacobian.reshape(len(rows), -1) * mask
    return np.asarray(np.einsum("qi,qij,qj->q", j, window.gather(values), j, optimize=True))


def kept_conditions(gauge: CoefficientRows, active: BoolArray, best: ConditionedSolution) -> BoolArray:
    """Which conditions to keep; jointly for curves that can be parametrised anew as a whole."""
    keep = needed_conditions(active, leverage_of(gauge, best.assembler, best.solution))
    curves = best.assembler.prepared.network.curves
    for number in np.unique(gauge.curve[active & ~keep]):
        if FAMILIES[curves[number].family].gauge_fraction == TIGHT:
            rows = np.flatnonzero(active & (gauge.curve == number))
            keep[rows] = jointly_needed(joint_cofactors(gauge.select(rows), best))
    return keep


def joint_cofactors(rows: CoefficientRows, best: ConditionedSolution) -> FloatArray:
    """G Q G' of some rows at a solution, (q, q)."""
    factor, layout = best.solution.factor, best.assembler.layout
    if factor is None:
        return np.eye(len(rows))
    matrix = np.zeros((len(rows), int(layout.node_starts[-1])))
    place = layout.unknown_of_coefficient[rows.columns][:, :, None] + np.arange(3)
    jacobian = rows.jacobian * layout.coefficient_mask[rows.columns]
    np.add.at(matrix, (np.arange(len(rows))[:, None, None], place), jacobian)
    return np.asarray(matrix @ factor.solve(np.ascontiguousarray(matrix.T)))


def returning_conditions(gauge: CoefficientRows, failed: ConditionedSolution, share: float) -> BoolArray:
    """Conditions that a solution lacks on the stretches that kept it from settling, (q,).

    Those that go on moving; where all move but little, those that do so by more than a share of the worst.
    """
    solution, assembler = failed.solution, failed.assembler
    lacking = np.ones(len(gauge), dtype=bool)
    lacking[failed.conditions] = False
    if not len(solution.unrest) or not lacking.any():
        return np.zeros(len(gauge), dtype=bool)
    of_rows = Stretches.of(assembler.layout, assembler.prepared.curves).of_columns(gauge.columns)
    unrest = np.where(lacking, solution.unrest[of_rows], 0.0)
    worst, moving = float(unrest.max()), UNSETTLED * assembler.deviation(solution.linearization) ** 2
    return np.asarray(unrest > min(moving, share * worst))


def solve_with_conditions(
    prepared: Prepared, layout: ParameterLayout, control: CoefficientRows, gauge: CoefficientRows, state: State,
    *, max_iterations: int, stage: str, damping: float, observer: Observer | None, select: bool = True,
) -> ConditionedSolution:  # fmt: skip
    """Solve with all gauge conditions, then with those that are needed.

    Parameters
    ----------
    control : equations of the curves' given values
    gauge : tangential conditions of all anchors
    select : False keeps all conditions
    """

    def with_conditions(active: BoolArray, begin: State, damping: float) -> ConditionedSolution:
        chosen = np.flatnonzero(active)
        rows = concatenate_rows([control, gauge.select(chosen)], prepared.curves.support)
        assembler = Assembler(prepared, layout, rows)
        solution = solve(
            assembler, begin, max_iterations=max_iterations, stage=stage, damping=damping, observer=observer
        )
        return ConditionedSolution(assembler, solution, chosen)

    active = np.ones(len(gauge), dtype=bool)
    best = with_conditions(active, state, damping)
    if not select or not len(gauge):
        return best
    settling = np.zeros(len(gauge), dtype=bool)  # conditions without which nothing settles
    returned = np.zeros(len(gauge), dtype=np.int64)  # how often a condition came back: after twice it stays
    for _ in range(ROUNDS):
        if not best.solution.converged:
            break
        keep = kept_conditions(gauge, active, best) | settling | (returned > 1)
        if np.array_equal(keep, active):
            break
        found = with_conditions(keep, best.solution.state, 0.0)
        for share in SHARES:
            back = returning_conditions(gauge, found, share)
            if found.solution.converged or not back.any():
                break
            settling, keep = settling | back, keep | back
            found = with_conditions(keep, found.solution.state, 0.0)
        if not found.solution.converged:
            break
        returned += keep & ~active
        active, best = keep, found
    return best
