"""Results in the project's order: what took no part comes back with its predicted residual.

For a measurement that is out, v is taken against the adjusted values (a point on a curve: at its foot point, across),
its standardised residual is v / (sigma sqrt(1 + a Q a')), and its redundancy number is 0, so that the redundancy
numbers of a table still sum to those of the adjustment.  Reweighted measurements have the residuals, redundancy numbers
and w of the weights that they had.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from splinebba_cli.core.evidence import Rejection, Reliability, Revision
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.redundancy import redundancy_numbers
from splinebba_cli.core.quality.residual_tables import (
    arc_table,
    curve_table,
    distance_table,
    point_table,
    tangent_table,
)
from splinebba_cli.core.result import AdjustmentResult, PointResult, ResidualTable, ScalarResiduals
from splinebba_cli.core.revision.observation_list import ARCS, CURVES, DISTANCES, KINDS, POINTS, TANGENTS
from splinebba_cli.core.revision.observation_weights import lost_points
from splinebba_cli.core.revision.revise import Revised
from splinebba_cli.core.revision.revision_findings import revision_problems
from splinebba_cli.core.revision.revision_log import residual_of_entries
from splinebba_cli.core.revision.weighted_solution import WeightedSolution

Rows = TypeVar("Rows", ResidualTable, ScalarResiduals, Reliability)
Table = TypeVar("Table", ResidualTable, ScalarResiduals)


def restored(result: AdjustmentResult, revised: Revised) -> AdjustmentResult:
    """The result of what took part, with all measurements in the project's order and the log of the search."""
    search = revised.search
    method = search.network.settings.outliers.method
    if revised.against is None and method == "none" and not revised.stopped:
        return result
    revision = _revision(revised)
    problems = (*revision_problems(revision, revised, result), *result.problems)
    network = replace(search.network, curves=result.network.curves)
    if revised.against is None and (revised.factor == 1.0).all():
        return replace(result, network=network, revision=revision, problems=problems)
    full = _predicted(revised, revised.against) if revised.against is not None else (None,) * 5
    points, curves, arcs, tangents, distances = revised.part.rows
    return replace(
        result,
        network=network,
        points=_without_lost(result, revised),
        point_residuals=_merged(result.point_residuals, full[0], points),
        curve_residuals=_merged(result.curve_residuals, full[1], curves),
        arc_residuals=_with_sigma(_merged(result.arc_residuals, full[2], arcs), network.arc_lengths.sigma),
        tangent_residuals=_with_sigma(
            _merged(result.tangent_residuals, full[3], tangents), network.tangents.sigma
        ),
        distance_residuals=_with_sigma(
            _merged(result.distance_residuals, full[4], distances), network.distances.sigma
        ),
        revision=revision,
        problems=problems,
    )


def _revision(revised: Revised) -> Revision:
    search, against = revised.search, revised.against
    policy = search.network.settings.outliers
    rejections: tuple[Rejection, ...] = ()
    if against is not None:
        residual = residual_of_entries(search.listed, against.statistics)
        rejections = search.log.rejections(against.statistics, residual, search.listed.row)
    parts = [search.listed.part(revised.factor, kind) for kind in range(len(KINDS))]
    weights = [None if (part == 1.0).all() else part.copy() for part in parts]
    return Revision(policy.method, policy.start, revised.rounds, rejections, *weights)


def _predicted(
    revised: Revised, against: WeightedSolution
) -> tuple[ResidualTable, ResidualTable, ScalarResiduals, ScalarResiduals, ScalarResiduals]:
    """Tables of all measurements, of which those that are out are used."""
    solved, listed = against.solved, revised.search.listed
    prepared = solved.assembler.prepared
    cofactors = Cofactors(solved.assembler, solved.solution)
    numbers = redundancy_numbers(cofactors, linked_cofactors(cofactors))
    unknown = np.full(len(prepared.network.curve_observations), np.nan)
    w = [listed.part(against.statistics.standardized, kind) for kind in range(len(KINDS))]
    return (
        _as_predictions(point_table(prepared, solved, numbers, np.nan), w[POINTS]),
        _as_predictions(curve_table(prepared, solved, numbers, unknown, np.nan), w[CURVES]),
        _as_predictions(arc_table(prepared, solved, numbers, np.nan), w[ARCS][:, 0]),
        _as_predictions(tangent_table(prepared, solved, numbers, np.nan), w[TANGENTS][:, 0]),
        _as_predictions(distance_table(prepared, solved, numbers, np.nan), w[DISTANCES][:, 0]),
    )


def _as_predictions(table: Table, standardized: FloatArray) -> Table:
    """What took no part: its errors are no part of the reliability (noncentrality NaN)."""
    return replace(table, redundancy=np.zeros_like(table.redundancy), standardized=standardized)


def _merged(own: Rows, full: Rows | None, rows: IntArray) -> Rows:
    """All rows, of which `rows` have their own residuals."""
    if full is None:
        return own
    merged: dict[str, Any] = {}
    for each in fields(full):
        theirs, mine = getattr(full, each.name), getattr(own, each.name)
        if isinstance(theirs, Reliability):
            merged[each.name] = _merged(mine, theirs, rows)
        else:
            merged[each.name] = theirs.copy()
            merged[each.name][rows] = mine
    return replace(full, **merged)


def _with_sigma(table: ScalarResiduals, sigma: FloatArray) -> ScalarResiduals:
    return replace(table, sigma=sigma)


def _without_lost(result: AdjustmentResult, revised: Revised) -> PointResult:
    """Points that no measurement locates any more keep their last place and have no precision."""
    lost = lost_points(revised.search.listed, revised.factor)
    if not len(lost):
        return result.points
    dispersion = result.points.dispersion.copy()
    dispersion[lost] = np.nan
    return replace(result.points, dispersion=dispersion)
