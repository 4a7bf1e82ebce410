"""From the solution to the result: statistics, dispersion, residuals, curves, checks and problems."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.curves.registry import lasting_parameters
from splinebba_cli.core.estimation.blas_threads import one_thread
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.datum import free_directions
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.evidence import Evidence
from splinebba_cli.core.network import Network
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.adjustment_statistics import dispersion_scale, statistics_of
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
from splinebba_cli.core.quality.influences import influences
from splinebba_cli.core.quality.inner_datum import STransformation
from splinebba_cli.core.quality.linked_cofactors import LinkedCofactors, linked_cofactors
from splinebba_cli.core.quality.local_findings import local_findings
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

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Adjusted:
    """What the estimation hands over."""

    prepared: Prepared
    solved: ConditionedSolution
    problems: tuple[Problem, ...]
    iterations: tuple[Iteration, ...]
    weights: WeightFactors = AS_GIVEN


@dataclass(frozen=True)
class _Figures:
    """What every part of the result needs."""

    adjusted: Adjusted
    cofactors: Cofactors
    linked: LinkedCofactors
    numbers: RedundancyNumbers
    statistics: Statistics
    scale: float  # of the cofactors
    delta0: float  # noncentrality of the tests

    @classmethod
    def of(cls, adjusted: Adjusted) -> _Figures:
        prepared, solved = adjusted.prepared, adjusted.solved
        _log.info("dispersion")
        cofactors = Cofactors(solved.assembler, solved.solution, _datum(prepared, solved))
        linked = linked_cofactors(cofactors)
        numbers = redundancy_numbers(cofactors, linked)
        statistics = statistics_of(prepared, solved, numbers)
        conditions = solved.assembler.coefficient_rows.component >= GAUGE
        delta0 = delta0_of(prepared.network.settings.testing, numbers.tested(conditions))
        scale = dispersion_scale(prepared.network, statistics)
        return cls(adjusted, cofactors, linked, numbers, statistics, scale, delta0)


def evaluate(adjusted: Adjusted, *, full_dispersion: bool = False) -> AdjustmentResult:
    """Everything that follows from a solution; the cofactors are given up before the model as a whole is tested."""
    result, numbers = _evaluated(adjusted, full_dispersion)
    _log.info("tests of the model")
    with one_thread():  # sums of the same digits with any number of them
        return with_model_evidence(result, adjusted.solved, numbers, adjusted.weights)


def _evaluated(adjusted: Adjusted, full_dispersion: bool) -> tuple[AdjustmentResult, RedundancyNumbers]:
    """All but the evidence about the model as a whole."""
    figures = _Figures.of(adjusted)
    prepared, solution = adjusted.prepared, adjusted.solved.solution
    _log.info("residuals and their tests")
    tables = _residual_tables(figures)
    samples = curve_samples(figures.cofactors, figures.scale)
    on_curves = tables["curve_residuals"]
    worst = influences(
        figures.cofactors,
        adjusted.solved,
        figures.numbers,
        on_curves,
        tables["point_residuals"],
        figures.delta0,
    )
    result = AdjustmentResult(
        network=_with_knot_parameters(prepared),
        converged=solution.converged,
        termination=solution.termination,
        iterations=adjusted.iterations,
        statistics=figures.statistics,
        images=_images(figures),
        curves=curve_results(figures.cofactors, samples, on_curves, figures.scale),
        points=_points(figures),
        checks=_checks(figures),
        problems=adjusted.problems,
        dispersion=dispersion_blocks(figures.cofactors, figures.scale) if full_dispersion else None,
        **tables,
    )
    tests = local_tests_of(result)
    evidence = Evidence(tests=tests, influences=worst, precision=position_precision(result))
    found = (
        *adjusted.problems,
        *findings(result),
        *local_findings(result, tests),
        *check_findings(result.checks),
        *curve_findings(prepared, solution.state),
        *arc_findings(prepared, solution.state),
    )
    return replace(result, evidence=evidence, problems=found), figures.numbers


def _residual_tables(figures: _Figures) -> dict[str, Any]:
    """Residuals of all kinds, by the attribute of the result that holds them."""
    prepared, solved, numbers = figures.adjusted.prepared, figures.adjusted.solved, figures.numbers
    variance = location_cofactors(figures.cofactors, figures.linked) * figures.scale
    locations = np.sqrt(np.maximum(variance, 0.0))
    return {
        "point_residuals": point_table(prepared, solved, numbers, figures.delta0),
        "curve_residuals": curve_table(prepared, solved, numbers, locations, figures.delta0),
        "arc_residuals": arc_table(prepared, solved, numbers, figures.delta0),
        "tangent_residuals": tangent_table(prepared, solved, numbers, figures.delta0),
        "distance_residuals": distance_table(prepared, solved, numbers, figures.delta0),
        "prior_residuals": prior_residuals(prepared, solved, numbers, figures.delta0),
    }


def _images(figures: _Figures) -> ImageResult:
    network, state = figures.adjusted.prepared.network, figures.adjusted.solved.solution.state
    eop = eop_values(network.images, state.rotation, state.position)
    eop[:, 3:] += network.origin
    return ImageResult(
        eop=eop,
        rotation=state.rotation,
        dispersion=eop_dispersion(network.images, state.rotation, figures.cofactors.images * figures.scale),
        estimated=figures.cofactors.image_mask > 0.0,
    )


def _points(figures: _Figures) -> PointResult:
    network = figures.adjusted.prepared.network
    return PointResult(
        xyz=figures.adjusted.solved.solution.state.xyz + network.origin,
        dispersion=figures.cofactors.points.own * figures.scale,
        rays=np.bincount(network.point_observations.point, minlength=len(network.points.ids)),
    )


def _checks(figures: _Figures) -> Checks:
    settings = figures.adjusted.prepared.network.settings
    variance = VarianceFactor(figures.scale, variance_degrees(settings, figures.statistics))
    single, summary = check_points(figures.cofactors, variance)
    return Checks(single, check_splines(figures.cofactors, variance), summary)


def _datum(prepared: Prepared, solved: ConditionedSolution) -> STransformation | None:
    """The way from the datum of the solution to an inner one, where that is wanted and something is free."""
    if prepared.network.settings.datum != "inner":
        return None
    if not free_directions(prepared, layout_of(prepared), solved.solution.state).count:
        return None
    return STransformation.at(prepared, ObservationEffects(solved.assembler, solved.solution))


def _with_knot_parameters(prepared: Prepared) -> Network:
    """The network with the knot parameters of its curves written out: later values keep them."""
    curves = tuple(
        replace(curve, knot_parameters=lasting_parameters(curve, basis), closed=basis.closed)
        for curve, basis in zip(prepared.network.curves, prepared.curves.bases, strict=True)
    )
    return replace(prepared.network, curves=curves)
