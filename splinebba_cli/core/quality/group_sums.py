"""Weighted squares and redundancy of every group of observations, and its rows in the sparse design."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.observation_groups import ANGLES, ObservationGroup
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.residual_projector import ResidualProjector


@dataclass(frozen=True)
class GroupSum:
    """Of one group."""

    group: ObservationGroup
    equations: int  # scalar; points on splines across only, unless they are held or linked
    squares: float  # v'Pv, whitened
    redundancy: float  # sum of redundancy numbers
    rows: IntArray  # in the sparse design
    complete: bool  # whether all of its equations are rows of the sparse design


def group_sums(
    projector: ResidualProjector, numbers: RedundancyNumbers, groups: tuple[ObservationGroup, ...]
) -> list[GroupSum]:
    """Sums of all groups at a solution."""
    every = _redundancies(numbers, projector)
    return [_sum_of(projector, numbers, every, group) for group in groups]


def _sum_of(
    projector: ResidualProjector, numbers: RedundancyNumbers, every: FloatArray, group: ObservationGroup
) -> GroupSum:
    linked, rows = projector.solution.linearization.linked, group.rows
    none = np.zeros(0, dtype=np.int64)
    if group.kind == "arc length":
        return _summed(group, linked.arc_residual[rows], numbers.arc_lengths[rows], none, complete=False)
    if group.kind == "tangent":
        return _summed(group, linked.tangent_residual[rows], numbers.tangents[rows], none, complete=False)
    places = _places(projector, group)
    r = every[places]
    v = projector.design.residual[places]
    if group.kind == "spline":
        tied = rows[projector.assembler.prepared.chains.linked[rows]]
        v = np.concatenate([v, linked.along[tied]])
        r = np.concatenate([r, numbers.linked_along[tied]])
        return _summed(group, v, r, places, complete=not len(tied))
    return _summed(group, v, r, places, complete=True)


def _summed(
    group: ObservationGroup, v: FloatArray, r: FloatArray, rows: IntArray, *, complete: bool
) -> GroupSum:
    return GroupSum(group, len(v), float(v @ v), float(r.sum()), rows, complete)


def _redundancies(numbers: RedundancyNumbers, projector: ResidualProjector) -> FloatArray:
    """Redundancy numbers in the order of the sparse design."""
    active = projector.solution.linearization.orientation_priors.active
    return np.concatenate(
        [
            numbers.curve_rows,
            numbers.image_points.ravel(),
            numbers.distances,
            numbers.orientation_priors[active],
            numbers.point_priors[projector.assembler.point_inverse_sigma > 0.0],
            numbers.coefficient_rows,
        ]
    )


def _places(projector: ResidualProjector, group: ObservationGroup) -> IntArray:
    """Rows of a group in the sparse design."""
    ranges, at = projector.design.ranges, projector.solution.linearization
    if group.kind == "spline":
        curve = projector.design.curve
        member = np.zeros(len(curve.normal), dtype=bool)
        member[group.rows] = True
        return np.flatnonzero(member[curve.point])
    if group.kind == "point":
        return ranges.points + (2 * group.rows[:, None] + np.arange(2)).ravel()
    if group.kind == "distance":
        return ranges.distances + group.rows
    if group.kind == "control point":
        return np.arange(ranges.control, ranges.coefficients)
    if group.kind == "control spline":
        return ranges.coefficients + np.flatnonzero(_stochastic_values(projector))
    q, c = np.nonzero(at.orientation_priors.active)
    key = 6 * at.orientation_priors.image[q] + c
    mine = np.isin(key, group.rows) & ((c < 3) == (group.name == ANGLES))
    return ranges.priors + np.flatnonzero(mine)


def _stochastic_values(projector: ResidualProjector) -> BoolArray:
    """Which equations over coefficients are given values with a sigma (no conditions, no held values), (q,)."""
    rows, curves = projector.assembler.coefficient_rows, projector.assembler.prepared.network.curves
    bounds = np.cumsum([0, *(len(curve.sigma) for curve in curves)])
    sigma = np.concatenate([np.zeros((0, 3)), *(curve.sigma for curve in curves)])
    given = np.zeros(len(rows), dtype=bool)
    own = np.flatnonzero(rows.component < GAUGE)
    given[own] = sigma[bounds[rows.curve[own]] + rows.row[own], rows.component[own]] > 0.0
    return given
