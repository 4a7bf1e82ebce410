"""From the solution to the result: statistics, dispersion, residuals, curves, checks and problems."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, TIGHT, lasting_parameters
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution, joint_cofactors
from splinebba_cli.core.estimation.counts import count_equations
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.evidence import Evidence
from splinebba_cli.core.network import BoolArray, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE
from splinebba_cli.core.quality.arc_findings import arc_findings
from splinebba_cli.core.quality.check_findings import check_findings
from splinebba_cli.core.quality.check_points import check_points
from splinebba_cli.core.quality.check_splines import check_splines
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.curve_findings import curve_findings
from splinebba_cli.core.quality.curve_precision import curve_samples
from splinebba_cli.core.quality.curve_results import curve_results
from splinebba_cli.core.quality.findings import findings
from splinebba_cli.core.quality.full_dispersion import dispersion_blocks
from splinebba_cli.core.quality.global_test import global_test
from splinebba_cli.core.quality.influences import influences
from splinebba_cli.core.quality.inner_datum import STransformation
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.location_precision import location_cofactors
from splinebba_cli.core.quality.model_evidence import AS_GIVEN, WeightFactors, with_model_evidence
from splinebba_cli.core.quality.observation_effects import ObservationEffects
from splinebba_cli.core.quality.orientation_dispersion import eop_dispersion, eop_values
from splinebba_cli.core.quality.position_precision import position_precision
from splinebba_cli.core.quality.prior_residuals import prior_residuals
from splinebba_cli.core.quality.redundancy import RedundancyNumbers, redundancy_numbers
from splinebba_cli.core.quality.reliability import delta0_of, local_tests_of
from splinebba_cli.core.quality.residual_tables import (
    arc_table,
    curve_table,
    distance_table,
    point_table,
    tangent_table,
)
from splinebba_cli.core.quality.variance_factor import VarianceFactor, variance_degrees
from splinebba_cli.core.result import (
    AdjustmentResult,
    Checks,
    ImageResult,
    Iteration,
    PointResult,
    Problem,
    Statistics,
)
from splinebba_cli.core.state import Prepared

PURE_GAUGE = 1e-6  # redundancy below which a condition only fills a defect


@dataclass(frozen=True)
class Adjusted:
    """What the estimation hands over."""

    prepared: Prepared
    solved: ConditionedSolution
    problems: tuple[Problem, ...]
    iterations: tuple[Iteration, ...]
    weights: WeightFactors = AS_GIVEN


def evaluate(adjusted: Adjusted, *, full_dispersion: bool = False) -> AdjustmentResult:
    """Everything that follows from a solution."""
    prepared, solved = adjusted.prepared, adjusted.solved
    network, solution = prepared.network, solved.solution
    cofactors = Cofactors(solved.assembler, solution, _datum(prepared, solved))
    linked = linked_cofactors(cofactors)
    numbers = redundancy_numbers(cofactors, linked)
    statistics = _statistics(prepared, solved, numbers)
    scale = dispersion_scale(network, statistics)
    samples = curve_samples(cofactors, scale)
    locations = np.sqrt(np.maximum(location_cofactors(cofactors, linked) * scale, 0.0))
    conditions = solved.assembler.coefficient_rows.component >= GAUGE
    delta0 = delta0_of(network.settings.testing, numbers.tested(conditions))
    residuals = curve_table(prepared, solved, numbers, locations, delta0)
    on_points = point_table(prepared, solved, numbers, delta0)
    worst = influences(cofactors, solved, numbers, residuals, on_points, delta0)
    curves = curve_results(cofactors, samples, residuals, scale)
    state = solution.state
    points = cofactors.points.own * scale
    variance = VarianceFactor(scale, variance_degrees(network.settings, statistics))
    single, summary = check_points(cofactors, variance)
    checks = Checks(single, check_splines(cofactors, variance), summary)
    eop = eop_values(network.images, state.rotation, state.position)
    eop[:, 3:] += network.origin
    images = ImageResult(
        eop=eop,
        rotation=state.rotation,
        dispersion=eop_dispersion(network.images, state.rotation, cofactors.images * scale),
        estimated=cofactors.image_mask > 0.0,
    )
    result = AdjustmentResult(
        network=_with_knot_parameters(prepared),
        converged=solution.converged,
        termination=solution.termination,
        iterations=adjusted.iterations,
        statistics=statistics,
        images=images,
        curves=curves,
        points=PointResult(
            xyz=state.xyz + network.origin,
            dispersion=points,
            rays=np.bincount(network.point_observations.point, minlength=len(network.points.ids)),
        ),
        point_residuals=on_points,
        curve_residuals=residuals,
        arc_residuals=arc_table(prepared, solved, numbers, delta0),
        tangent_residuals=tangent_table(prepared, solved, numbers, delta0),
        distance_residuals=distance_table(prepared, solved, numbers, delta0),
        prior_residuals=prior_residuals(prepared, solved, numbers, delta0),
        checks=checks,
        problems=adjusted.problems,
        dispersion=dispersion_blocks(cofactors, scale) if full_dispersion else None,
    )
    evidence = Evidence(tests=local_tests_of(result), influences=worst, precision=position_precision(result))
    result = replace(result, evidence=evidence)
    found = replace(
        result,
        problems=(
            *adjusted.problems,
            *findings(result),
            *check_findings(checks),
            *curve_findings(prepared, state),
            *arc_findings(prepared, state),
        ),
    )
    return with_model_evidence(found, solved, numbers, adjusted.weights)


def _datum(prepared: Prepared, solved: ConditionedSolution) -> STransformation | None:
    """The way from the datum of the solution to an inner one, where that is wanted."""
    if prepared.network.settings.datum != "inner":
        return None
    return STransformation.at(prepared, ObservationEffects(solved.assembler, solved.solution))


def dispersion_scale(network: Network, statistics: Statistics) -> float:
    """Factor of the cofactors (which belong to weights 1/sigma^2)."""
    if not network.settings.scale_dispersion or statistics.redundancy < 1:
        return 1.0
    return (statistics.sigma0 / statistics.sigma0_prior) ** 2


def _statistics(prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers) -> Statistics:
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
        global_test=global_test(vtpv, redundancy, settings.sigma0_prior, settings.alpha),
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


def _with_knot_parameters(prepared: Prepared) -> Network:
    """The network with the knot parameters of its curves written out: later values keep them."""
    curves = tuple(
        replace(curve, knot_parameters=lasting_parameters(curve, basis), closed=basis.closed)
        for curve, basis in zip(prepared.network.curves, prepared.curves.bases, strict=True)
    )
    return replace(prepared.network, curves=curves)
