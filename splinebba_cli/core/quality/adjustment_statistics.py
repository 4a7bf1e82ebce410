"""Counts, variance of unit weight and global test of a solution.

r = observations + conditions - unknowns,    sigma0^2 = v'Pv / r
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, TIGHT
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution, joint_cofactors
from splinebba_cli.core.estimation.counts import count_equations
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import BoolArray, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE
from splinebba_cli.core.quality.global_test import global_test
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.result import Statistics
from splinebba_cli.core.state import Prepared

PURE_GAUGE = 1e-6  # redundancy below which a condition only fills a defect


def dispersion_scale(network: Network, statistics: Statistics) -> float:
    """Factor of the cofactors (which belong to weights 1/sigma^2)."""
    if not network.settings.scale_dispersion or statistics.redundancy < 1:
        return 1.0
    return (statistics.sigma0 / statistics.sigma0_prior) ** 2


def statistics_of(prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers) -> Statistics:
    """Statistics of a solution."""
    settings, at = prepared.network.settings, solved.solution.linearization
    assembler = solved.assembler
    component = assembler.coefficient_rows.component
    is_gauge, is_condition = component == GAUGE, component >= GAUGE
    equations = count_equations(assembler, at) - int((component == SHAPE).sum())
    locations = len(prepared.network.curve_observations) - len(solved.solution.held)
    full = layout_of(prepared)
    datum = int(full.image_mask.sum() - assembler.layout.image_mask.sum())
    unknowns = int(full.reduced_mask().sum() + full.eliminated_mask.sum()) + locations
    conditions = int(is_condition.sum()) + datum
    redundancy = equations + conditions - unknowns
    vtpv = at.cost * settings.sigma0_prior**2
    sigma0 = float(np.sqrt(vtpv / redundancy)) if redundancy > 0 else float("nan")
    of_gauge = max(float(numbers.coefficient_rows[is_gauge].sum()), 0.0)
    condition_numbers: FloatArray = numbers.coefficient_rows[is_condition]
    return Statistics(
        observations=equations,
        unknowns=unknowns,
        conditions=conditions,
        rank_defect=_filled_defect(solved, numbers, is_gauge) + datum,
        redundancy=redundancy,
        sum_redundancy_numbers=numbers.total,
        condition_redundancy=float(condition_numbers.sum()),
        condition_cost=float(np.sum(at.coefficient_residual[is_condition] ** 2)) * settings.sigma0_prior**2,
        vtpv=vtpv,
        sigma0_prior=settings.sigma0_prior,
        sigma0=sigma0,
        global_test=global_test(vtpv, redundancy, settings.sigma0_prior, settings.alpha, of_gauge),
    )


def _filled_defect(solved: ConditionedSolution, numbers: RedundancyNumbers, is_gauge: BoolArray) -> int:
    """Number of directions that gauge conditions alone determine: where all of their leverage is 1.

    Conditions of one curve that hold the same direction share it, so that only together they fill the defect.
    """
    rows, own = solved.assembler.coefficient_rows, numbers.coefficient_rows
    curves = solved.assembler.prepared.network.curves
    shared = np.array([FAMILIES[curve.family].gauge_fraction == TIGHT for curve in curves], dtype=bool)
    together = is_gauge & (shared[rows.curve] if len(curves) else False)
    count = int((own[is_gauge & ~together] < PURE_GAUGE).sum())
    for number in np.unique(rows.curve[together]):
        chosen = np.flatnonzero(together & (rows.curve == number))
        free = np.eye(len(chosen)) - joint_cofactors(rows.select(chosen), solved)
        count += int((np.linalg.eigvalsh(free) < PURE_GAUGE).sum())
    return count
