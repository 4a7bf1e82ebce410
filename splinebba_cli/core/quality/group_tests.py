"""Tests of whole groups of observations against one error that they share (bias_tests.py).

    chain           all points of one spline in one image, shifted across it by one distance       1 unknown
    control spline  all given values of one spline, displaced as a whole                           3
    control point   its given coordinates                                                          3

Single residuals of a chain on a wrong edge stay small: the spline, the orientation and the other chains share the
error among themselves.  The test adds up what all of them show.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse

from splinebba_cli.core.evidence import GroupTest
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.bias_tests import BiasTest, TestFamily, bias_tests
from splinebba_cli.core.quality.control_directions import control_point_directions, control_spline_directions
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import Statistics
from splinebba_cli.core.row_groups import RowGroups

FEWEST = 3  # points of a chain: fewer are judged one by one


@dataclass(frozen=True)
class GroupTests:
    """Tests of groups, and how many groups there are: the tested ones are those with the largest mean residuals."""

    tests: tuple[GroupTest, ...]
    possible: int


@dataclass(frozen=True)
class _Candidates:
    """All groups of one kind."""

    kind: Literal["chain", "control spline", "control point"]
    unknowns: int  # of the test of one group
    observations: IntArray  # (G,)
    suspicion: FloatArray  # (G,) size of the mean residual
    name: Callable[[int], str]
    directions: Callable[[int], sparse.csc_array]


def group_tests(projector: ResidualProjector, rows: PhotoRows, statistics: Statistics) -> GroupTests:
    """Test all groups, or as many as are affordable; alpha belongs to all groups together."""
    settings = projector.assembler.prepared.network.settings
    if statistics.redundancy < 1:
        return GroupTests((), 0)
    kinds = [_chains(projector, rows), _control_splines(projector), _control_points(projector)]
    count = [len(each.suspicion) for each in kinds]
    family = TestFamily.of(statistics, settings.testing, settings.alpha, sum(count))
    kind = np.repeat(np.arange(len(kinds)), count)
    number = np.concatenate([np.arange(each) for each in count])
    chosen = _worst(
        np.concatenate([each.suspicion for each in kinds]),
        np.array([each.unknowns for each in kinds])[kind],
        projector.affordable,
    )
    groups = [(kinds[k], n) for k, n in zip(kind[chosen].tolist(), number[chosen].tolist(), strict=True)]
    found = bias_tests(projector, [own.directions(n) for own, n in groups], family)
    tests = [
        _group_test(own, n, test, family)
        for (own, n), test in zip(groups, found, strict=True)
        if test.freedom
    ]
    return GroupTests(tuple(tests), sum(count))


def _group_test(own: _Candidates, number: int, test: BiasTest, family: TestFamily) -> GroupTest:
    chain = own.kind == "chain"
    critical = family.critical(test.freedom)
    return GroupTest(
        kind=own.kind,
        name=own.name(number),
        model="shift across" if chain else "shift (3)",
        observations=int(own.observations[number]),
        parameters=test.freedom,
        estimate=test.estimate,
        sigma=test.sigma,
        unit="mm" if chain else "m",
        statistic=test.statistic,
        critical=critical,
        passed=bool(test.statistic <= critical),
        minimal_detectable=test.minimal_detectable,
        probability=family.of_all(test.probability),
    )


def _worst(suspicion: FloatArray, unknowns: IntArray, affordable: int) -> IntArray:
    """The most suspicious groups, with so many unknowns together; in their order."""
    order = np.argsort(-suspicion, kind="stable")
    return np.sort(order[np.cumsum(unknowns[order]) <= affordable])


def _chains(projector: ResidualProjector, rows: PhotoRows) -> _Candidates:
    """Every image on every spline."""
    network, across = projector.assembler.prepared.network, np.flatnonzero(rows.across)
    groups = RowGroups.of(rows.image[across] * (len(network.curves) + 1) + rows.curve[across])
    count = np.diff(groups.starts)
    total = np.add.reduceat(rows.residual[across[groups.order]], groups.starts[:-1]) if len(count) else count
    enough = np.flatnonzero(count >= FEWEST)

    def members(number: int) -> IntArray:
        begin, end = groups.starts[enough[number]], groups.starts[enough[number] + 1]
        return across[groups.order[begin:end]]

    def name(number: int) -> str:
        row = across[groups.representative[enough[number]]]
        return (
            f"image `{network.images.ids[rows.image[row]]}` on spline `{network.curves[rows.curve[row]].id}`"
        )

    return _Candidates(
        "chain", 1, count[enough], np.abs(total[enough]) / np.sqrt(count[enough]), name,
        lambda number: _across(rows, members(number)),
    )  # fmt: skip


def _across(rows: PhotoRows, own: IntArray) -> sparse.csc_array:
    """A shift across of one chain."""
    normal = rows.sensitivity[own] / np.linalg.norm(rows.sensitivity[own], axis=1)[:, None]
    return rows.directions(own, normal[:, None, :])


def _control_splines(projector: ResidualProjector) -> _Candidates:
    network, ranges = projector.assembler.prepared.network, projector.design.ranges
    count, residual = len(network.curves), projector.design.residual
    curve = network.curve_observations.curve[projector.design.curve.point]
    values = projector.assembler.coefficient_rows
    known = values.component < GAUGE
    of_values = _rms(values.curve[known], residual[ranges.coefficients + np.flatnonzero(known)], count)
    of_points = _rms(curve, residual[: len(curve)], count)
    given = np.array([np.isfinite(each.sigma).sum() for each in network.curves], dtype=np.int64)
    chosen = np.flatnonzero(given)
    has_values = np.bincount(values.curve[known], minlength=count) > 0
    size = np.where(has_values, of_values, of_points)
    return _Candidates(
        "control spline", 3, given[chosen], size[chosen],
        lambda number: f"control spline `{network.curves[chosen[number]].id}`",
        lambda number: control_spline_directions(
            projector, int(chosen[number]), np.flatnonzero(curve == chosen[number])
        ),
    )  # fmt: skip


def _control_points(projector: ResidualProjector) -> _Candidates:
    network, at = projector.assembler.prepared.network, projector.solution.linearization
    point, count = network.point_observations.point, len(network.points.ids)
    given = np.isfinite(network.points.sigma).sum(axis=1)
    chosen = np.flatnonzero((given > 0) & (np.bincount(point, minlength=count) > 0))
    of_rays = _rms(point.repeat(2), at.points.residual.ravel(), count)
    of_priors = np.sqrt(np.mean(at.point_prior_residual**2, axis=1))
    return _Candidates(
        "control point", 3, given[chosen], np.maximum(of_priors, of_rays)[chosen],
        lambda number: f"control point `{network.points.ids[chosen[number]]}`",
        lambda number: control_point_directions(
            projector, int(chosen[number]), np.flatnonzero(point == chosen[number])
        ),
    )  # fmt: skip


def _rms(group: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Root mean square of the values of every group, (count,); 0 of an empty one."""
    square = np.bincount(group, values**2, minlength=count)
    return np.asarray(np.sqrt(square / np.maximum(np.bincount(group, minlength=count), 1)))
