"""Evidence about the model as a whole: variances of groups, common errors of groups, systematic effects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.evidence import Evidence
from splinebba_cli.core.quality.component_tests import component_findings, variance_components
from splinebba_cli.core.quality.group_sums import group_sums
from splinebba_cli.core.quality.group_tests import group_tests
from splinebba_cli.core.quality.group_variances import group_variances
from splinebba_cli.core.quality.observation_groups import observation_groups
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.photo_trends import drifts, image_means, lens_trends
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.residual_grid import residual_grids
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.quality.runs_along_curves import runs_along_curves
from splinebba_cli.core.quality.strip_drifts import strip_drifts
from splinebba_cli.core.quality.systematic_findings import group_findings, systematic_findings
from splinebba_cli.core.result import AdjustmentResult, Statistics


@dataclass(frozen=True)
class WeightFactors:
    """Factors by which the given sigma of the groups were multiplied; groups in the order of observation_groups."""

    factor: tuple[float, ...] = ()
    estimated: tuple[bool, ...] = ()


AS_GIVEN = WeightFactors()


def with_model_evidence(
    result: AdjustmentResult, solved: ConditionedSolution, numbers: RedundancyNumbers, weights: WeightFactors
) -> AdjustmentResult:
    """The result with this evidence and its problems added."""
    projector = ResidualProjector(solved.assembler, solved.solution, numbers.curve)
    alpha = result.network.settings.alpha
    groups = observation_groups(result.network)
    sums = group_sums(projector, numbers, groups)
    components = variance_components(
        sums,
        group_variances(projector, sums),
        np.array(weights.factor or [1.0] * len(groups)),
        np.array(weights.estimated or [False] * len(groups)),
        alpha,
    )
    evidence = replace(result.evidence, variance_components=components)
    if result.statistics.redundancy > 0:
        evidence = _with_biases(evidence, projector, result.statistics, numbers)
    problems = (
        *result.problems,
        *component_findings(components, alpha, result.network.settings.outliers),
        *group_findings(evidence.groups),
        *systematic_findings(evidence.systematic),
    )
    return replace(result, evidence=evidence, problems=problems)


def _with_biases(
    evidence: Evidence, projector: ResidualProjector, statistics: Statistics, numbers: RedundancyNumbers
) -> Evidence:
    rows = PhotoRows.of(projector)
    tested = group_tests(projector, rows, statistics)
    grids, cells = residual_grids(projector, rows, statistics)
    effects = (
        *image_means(projector, rows, statistics),
        *lens_trends(projector, rows, statistics),
        *cells,
        *runs_along_curves(projector, rows, numbers.curve_rows),
        *drifts(projector, rows, statistics),
        *strip_drifts(projector, statistics),
    )
    return replace(
        evidence, groups=tested.tests, possible_groups=tested.possible, systematic=effects, grids=grids
    )
