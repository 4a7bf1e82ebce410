"""Tests of groups against what they stand for: the group corrected by its estimate, everything adjusted again.

By linear theory v'Pv falls by exactly T.  What is left is of second order in the correction, a few σ of a group: the
change of the direction of the normals and of the design, in these blocks below 2 % of T + 1.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.variance_components import shifted_chain
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import GroupTest
from splinebba_cli.core.network import Network
from splinebba_cli.core.quality.control_directions import control_spline_directions
from splinebba_cli.core.quality.group_tests import _worst, group_tests
from splinebba_cli.core.quality.photo_rows import PhotoRows
from splinebba_cli.core.quality.residual_projector import ResidualProjector
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.quality.test_residual_projector import systems


@cache
def network_of(kind: str) -> Network:
    """All gauge conditions in every solution, so that v'Pv can be compared."""
    network = simulate_block(kind, 5, start_position_m=0.1, start_angle_deg=0.01, start_knots_m=0.1)[0]
    return replace(network, settings=replace(network.settings, gauge_conditions="all"))


@cache
def adjusted(kind: str) -> AdjustmentResult:
    return adjust(network_of(kind))


def test_of(kind: str, name: str) -> GroupTest:
    (found,) = [test for test in adjusted(kind).evidence.groups if test.name == name]
    return found


test_of.__test__ = False  # type: ignore[attr-defined]


def decrease(kind: str, corrected: Network) -> float:
    return adjusted(kind).statistics.vtpv - adjust(corrected).statistics.vtpv


def same(found: float, test: GroupTest) -> bool:
    return found == pytest.approx(test.statistic, abs=0.02 * (test.statistic + 1.0))


@pytest.mark.parametrize("image", [1, 4])
def test_a_chain_without_its_shift(image: int) -> None:
    network = network_of("six-image-mixed")
    curve = [each.id for each in network.curves].index("lake")
    test = test_of("six-image-mixed", f"image `{network.images.ids[image]}` on spline `lake`")
    assert test.unit == "mm" and test.parameters == 1
    seen, normal = network.curve_observations, adjusted("six-image-mixed").curve_residuals.normal
    own = (seen.image == image) & (seen.curve == curve)
    xy = np.where(own[:, None], seen.photo_xy - test.estimate[0] * normal, seen.photo_xy)
    assert same(
        decrease("six-image-mixed", replace(network, curve_observations=replace(seen, photo_xy=xy))), test
    )


def test_a_control_point_without_its_displacement() -> None:
    network = network_of("six-image-mixed")
    test = test_of("six-image-mixed", "control point `gcp-5`")
    assert test.unit == "m" and test.parameters == 3
    xyz = network.points.xyz.copy()
    xyz[network.points.ids.index("gcp-5")] -= test.estimate
    assert same(decrease("six-image-mixed", replace(network, points=replace(network.points, xyz=xyz))), test)


def test_a_fixed_control_spline_without_its_displacement() -> None:
    """Its coefficients are no unknowns: the displacement enters the image observations."""
    network = network_of("six-image")
    test = test_of("six-image", "control spline `control-1`")
    k = [curve.id for curve in network.curves].index("control-1")
    assert (network.curves[k].sigma == 0.0).all()
    curves = list(network.curves)
    curves[k] = replace(curves[k], values=curves[k].values - test.estimate)
    assert same(decrease("six-image", replace(network, curves=tuple(curves))), test)


def test_a_partly_fixed_and_weighted_spline_moves_as_a_whole() -> None:
    """A displacement of held and weighted values alike, given free values too, is one of the whole curve: with all
    values given, image rows and value rows together see nothing else than the displaced curve."""
    projector, _, _ = systems()
    rows = projector.assembler.coefficient_rows
    curves = projector.assembler.prepared.network.curve_observations
    at = projector.solution.linearization.curve
    measured = np.flatnonzero(curves.curve[at.point] == 1)
    found = control_spline_directions(projector, 1, measured).toarray()
    values = np.flatnonzero((rows.curve == 1) & (rows.component < 3))
    assert len(values) and np.abs(found[projector.design.ranges.coefficients + values]).max() > 0.0
    others = np.setdiff1d(np.arange(len(rows)), values)
    assert not found[projector.design.ranges.coefficients + others].any()


def test_only_the_worst_are_tested_where_there_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their number counts in the level of significance all the same."""
    projector, _, _ = systems()
    rows, statistics = PhotoRows.of(projector), adjusted("six-image-mixed").statistics
    every = group_tests(projector, rows, statistics)
    monkeypatch.setattr(ResidualProjector, "affordable", 30)
    some = group_tests(projector, rows, statistics)
    assert len(some.tests) < len(every.tests) and some.possible == every.possible
    chains = {test.name: test for test in every.tests}
    for test in some.tests:
        assert test.critical == chains[test.name].critical
        assert test.statistic == pytest.approx(chains[test.name].statistic)


def test_a_wrong_chain_is_the_first_that_is_named() -> None:
    """By 30 µm, six times the σ of a point and fifteen times that of the common shift."""
    result = adjust(shifted_chain(network_of("six-image-mixed"), 30.0))
    named = [problem for problem in result.problems if problem.code == "SBB546"]
    assert named[0].subject == "image `5` on spline `tie-1`" and named[0].severity == "warning"
    (test,) = [test for test in result.evidence.groups if test.name == named[0].subject]
    assert 0.02 < abs(test.estimate[0]) < 0.035  # x is nearly across this spline


def test_where_not_all_are_affordable_the_most_suspicious_are_tested() -> None:
    suspicion, unknowns = np.array([1.0, 7.0, 3.0, 5.0]), np.array([1, 1, 1, 3])
    assert _worst(suspicion, unknowns, 1).tolist() == [1]
    assert _worst(suspicion, unknowns, 4).tolist() == [1, 3]
    assert _worst(suspicion, unknowns, 6).tolist() == [0, 1, 2, 3]
