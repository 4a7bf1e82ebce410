"""Tests of whole groups of observations against one error that they share (bias_tests.py).

    chain           all points of one spline in one image, shifted across it by one distance       1 unknown
    control spline  all given values of one spline, displaced as a whole                           3
    control point   its given coordinates                                                          3

Single residuals of a chain on a wrong edge stay small: the spline, the orientation and the other chains share the
error among themselves.  The test adds up what all of them show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from splinebba_cli.core.evidence import GroupTest
from splinebba_cli.core.network import FloatArray, IntArray
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
class _Candidate:
    kind: str
    name: str
    observations: int
    directions: sparse.csc_array


def group_tests(projector: ResidualProjector, rows: PhotoRows, statistics: Statistics) -> GroupTests:
    """Test all groups, or as many as are affordable; alpha belongs to all groups together."""
    settings = projector.assembler.prepared.network.settings
    if statistics.redundancy < 1:
        return GroupTests((), 0)
    control = [*_control_splines(projector), *_control_points(projector)]
    members = _chains(rows)
    possible = len(control) + len(members)
    family = TestFamily.of(statistics, settings.testing, settings.alpha, possible)
    affordable = projector.affordable
    control = control[: affordable // 3]
    members = _worst(rows, members, affordable - 3 * len(control))
    candidates = [*(_chain(projector, rows, own) for own in members), *control]
    found = bias_tests(projector, [candidate.directions for candidate in candidates], family)
    tests = [_group_test(c, test, family) for c, test in zip(candidates, found, strict=True) if test.freedom]
    return GroupTests(tuple(tests), possible)


def _group_test(candidate: _Candidate, test: BiasTest, family: TestFamily) -> GroupTest:
    chain = candidate.kind == "chain"
    critical = family.critical(test.freedom)
    return GroupTest(
        kind=candidate.kind,  # type: ignore[arg-type]
        name=candidate.name,
        model="shift across" if chain else "shift (3)",
        observations=candidate.observations,
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


def _chains(rows: PhotoRows) -> list[IntArray]:
    """Rows across of every image on every spline."""
    across = np.flatnonzero(rows.across)
    keys = rows.image[across] * (int(rows.curve.max(initial=0)) + 1) + rows.curve[across]
    groups = RowGroups.of(keys)
    members = [across[own] for own in np.split(groups.order, groups.starts[1:-1])] if len(across) else []
    return [own for own in members if len(own) >= FEWEST]


def _worst(rows: PhotoRows, members: list[IntArray], number: int) -> list[IntArray]:
    """At most `number` chains, those with the largest mean residuals over their sigma; in their order."""
    if len(members) <= number:
        return members
    size = np.array([abs(rows.residual[own].sum()) / np.sqrt(len(own)) for own in members])
    return [members[k] for k in np.sort(np.argsort(-size, kind="stable")[:number])]


def _chain(projector: ResidualProjector, rows: PhotoRows, own: IntArray) -> _Candidate:
    network = projector.assembler.prepared.network
    image, curve = network.images.ids[rows.image[own[0]]], network.curves[rows.curve[own[0]]].id
    normal: FloatArray = rows.sensitivity[own] / np.linalg.norm(rows.sensitivity[own], axis=1)[:, None]
    directions = rows.directions(own, normal[:, None, :])
    return _Candidate("chain", f"image `{image}` on spline `{curve}`", len(own), directions)


def _control_splines(projector: ResidualProjector) -> list[_Candidate]:
    at, network = projector.solution.linearization, projector.assembler.prepared.network
    owner = network.curve_observations.curve[at.curve.point]
    found = []
    for number, curve in enumerate(network.curves):
        given = int(np.isfinite(curve.sigma).sum())
        if given:
            directions = control_spline_directions(projector, number, np.flatnonzero(owner == number))
            found.append(_Candidate("control spline", f"control spline `{curve.id}`", given, directions))
    return found


def _control_points(projector: ResidualProjector) -> list[_Candidate]:
    network = projector.assembler.prepared.network
    point = network.point_observations.point
    found = []
    for number in np.flatnonzero(np.isfinite(network.points.sigma).any(axis=1)):
        rays = np.flatnonzero(point == number)
        if len(rays):
            name = f"control point `{network.points.ids[number]}`"
            given = int(np.isfinite(network.points.sigma[number]).sum())
            directions = control_point_directions(projector, int(number), rays)
            found.append(_Candidate("control point", name, given, directions))
    return found
