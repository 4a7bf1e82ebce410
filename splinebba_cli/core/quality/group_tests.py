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
from functools import partial

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
from splinebba_cli.core.row_groups import split_by

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
    unknowns: int
    suspicion: float  # size of its mean residual
    directions: Callable[[], sparse.csc_array]


def group_tests(projector: ResidualProjector, rows: PhotoRows, statistics: Statistics) -> GroupTests:
    """Test all groups, or as many as are affordable; alpha belongs to all groups together."""
    settings = projector.assembler.prepared.network.settings
    if statistics.redundancy < 1:
        return GroupTests((), 0)
    every = [*_chains(projector, rows), *_control_splines(projector), *_control_points(projector)]
    family = TestFamily.of(statistics, settings.testing, settings.alpha, len(every))
    chosen = _worst(every, projector.affordable)
    found = bias_tests(projector, [candidate.directions() for candidate in chosen], family)
    tests = [_group_test(c, test, family) for c, test in zip(chosen, found, strict=True) if test.freedom]
    return GroupTests(tuple(tests), len(every))


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


def _worst(candidates: list[_Candidate], affordable: int) -> list[_Candidate]:
    """The most suspicious ones, with so many unknowns together; in their order."""
    order = np.argsort([-candidate.suspicion for candidate in candidates], kind="stable")
    unknowns = np.cumsum([candidates[k].unknowns for k in order])
    return [candidates[k] for k in np.sort(order[unknowns <= affordable])]


def _chains(projector: ResidualProjector, rows: PhotoRows) -> list[_Candidate]:
    """Every image on every spline."""
    network, across = projector.assembler.prepared.network, np.flatnonzero(rows.across)
    members = split_by(rows.image[across] * (len(network.curves) + 1) + rows.curve[across])
    found = []
    for member in members:
        own = across[member]
        if len(own) >= FEWEST:
            image, curve = network.images.ids[rows.image[own[0]]], network.curves[rows.curve[own[0]]].id
            size = abs(float(rows.residual[own].sum())) / np.sqrt(len(own))
            name = f"image `{image}` on spline `{curve}`"
            found.append(_Candidate("chain", name, len(own), 1, size, partial(_across, rows, own)))
    return found


def _across(rows: PhotoRows, own: IntArray) -> sparse.csc_array:
    """A shift across of one chain."""
    normal = rows.sensitivity[own] / np.linalg.norm(rows.sensitivity[own], axis=1)[:, None]
    return rows.directions(own, normal[:, None, :])


def _control_splines(projector: ResidualProjector) -> list[_Candidate]:
    network = projector.assembler.prepared.network
    members = split_by(network.curve_observations.curve[projector.design.curve.point], len(network.curves))
    values = projector.assembler.coefficient_rows
    rows_of = split_by(
        np.where(values.component < GAUGE, values.curve, len(network.curves)), len(network.curves)
    )
    residual = projector.design.residual
    found = []
    for number, (curve, measured) in enumerate(zip(network.curves, members, strict=True)):
        given = int(np.isfinite(curve.sigma).sum())
        if given:
            known = projector.design.ranges.coefficients + rows_of[number]
            size = _rms(residual[known if len(known) else measured])
            name = f"control spline `{curve.id}`"
            build = partial(control_spline_directions, projector, number, measured)
            found.append(_Candidate("control spline", name, given, 3, size, build))
    return found


def _control_points(projector: ResidualProjector) -> list[_Candidate]:
    network, at = projector.assembler.prepared.network, projector.solution.linearization
    members = split_by(network.point_observations.point, len(network.points.ids))
    found = []
    for number in np.flatnonzero(np.isfinite(network.points.sigma).any(axis=1)).tolist():
        rays = members[number]
        if len(rays):
            given = int(np.isfinite(network.points.sigma[number]).sum())
            size = max(_rms(at.point_prior_residual[number]), _rms(at.points.residual[rays].ravel()))
            name = f"control point `{network.points.ids[number]}`"
            build = partial(control_point_directions, projector, number, rays)
            found.append(_Candidate("control point", name, given, 3, size, build))
    return found


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
