"""Check points and check splines: joint dispersions against the dense inverse, and what the tests find."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.quality.check_points import check_points, measured_checks, summary_of
from splinebba_cli.core.quality.check_splines import check_splines, offsets_of
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.joint_cofactors import point_cofactors
from splinebba_cli.core.quality.variance_factor import VarianceFactor
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.small_networks import dense_system, mixed_network, solved

KNOWN = VarianceFactor(1.0, None)


@cache
def system() -> tuple[Cofactors, FloatArray]:
    """Cofactors and the dense inverse of a mixed network; see tests/core/estimation/test_cofactors.py."""
    found = solved(mixed_network()[0])
    dense = dense_system(found.assembler, found.solution.linearization)
    return Cofactors(found.assembler, found.solution), dense.inverse


def rows_of_points(cofactors: Cofactors) -> FloatArray:
    start = int(cofactors.assembler.layout.node_starts[-1])
    points = measured_checks(cofactors.assembler.prepared.network)
    return (start + 3 * points[:, None] + np.arange(3)).ravel()


def test_points_together_against_the_dense_inverse() -> None:
    cofactors, inverse = system()
    place = rows_of_points(cofactors)
    expected = inverse[np.ix_(place, place)]
    sigma = np.sqrt(np.diag(expected))
    found = point_cofactors(cofactors, measured_checks(cofactors.assembler.prepared.network))
    assert np.abs((found - expected) / np.outer(sigma, sigma)).max() < 1e-9
    off = expected / np.outer(sigma, sigma) - np.kron(np.eye(len(place) // 3), np.ones((3, 3)))
    assert np.abs(off).max() > 0.1  # points share orientations: the blocks alone would be wrong


def test_joint_statistics_of_points() -> None:
    cofactors, inverse = system()
    network, place = cofactors.assembler.prepared.network, rows_of_points(cofactors)
    rows = measured_checks(network)
    sigma = network.points.check_sigma[rows]
    d = (cofactors.solution.state.xyz[rows] - network.points.xyz[rows]).ravel()
    dispersion = inverse[np.ix_(place, place)] + np.diag(sigma.ravel() ** 2)
    _, summary = check_points(cofactors, KNOWN)
    assert summary is not None and summary.together is not None and summary.shift is not None
    assert summary.together.statistic == pytest.approx(d @ np.linalg.solve(dispersion, d), rel=1e-7)
    mean = np.tile(np.eye(3), len(rows)) / len(rows)
    shift = (mean @ d) @ np.linalg.solve(mean @ dispersion @ mean.T, mean @ d)
    assert summary.shift.statistic == pytest.approx(shift, rel=1e-7)
    assert summary.together.critical == pytest.approx(stats.chi2.ppf(0.95, len(d)))


def test_spline_together_against_the_dense_inverse() -> None:
    """Satterthwaite's degrees of freedom from the dense inverse of the coefficients."""
    cofactors, inverse = system()
    prepared = cofactors.assembler.prepared
    k = next(k for k, curve in enumerate(prepared.network.curves) if curve.role == "check")
    found = offsets_of(cofactors, k)
    basis, start = prepared.curves.bases[k], int(prepared.curves.coefficient_start[k])
    count = basis.coefficient_count
    weights = np.stack(
        [basis.evaluate(found.u, unit[:, None] * np.ones(3))[:, 0] for unit in np.eye(count)], axis=1
    )
    place = cofactors.assembler.layout.unknown_of_coefficient[start : start + count][:, None] + np.arange(3)
    rows = np.einsum("pj,pak->pkja", weights, found.plane).reshape(2 * len(found.u), -1)
    joint = rows @ inverse[np.ix_(place.ravel(), place.ravel())] @ rows.T
    blocks = [joint[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(len(found.u))]
    d = np.einsum("pak,pa->pk", found.plane, found.across)
    square = [d[i] @ np.linalg.solve(block, d[i]) for i, block in enumerate(blocks)]
    root = np.zeros_like(joint)
    for i, block in enumerate(blocks):
        root[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = np.linalg.inv(np.linalg.cholesky(block))
    effective = len(joint) ** 2 / np.sum((root @ joint @ root.T) ** 2)
    (spline,) = check_splines(cofactors, KNOWN)
    assert spline.together is not None
    assert spline.together.degrees == pytest.approx(effective, rel=1e-6)
    assert spline.together.statistic == pytest.approx(sum(square) * effective / len(joint), rel=1e-6)
    assert spline.normalized[found.inside] == pytest.approx(np.sqrt(np.array(square) / 2.0), rel=1e-6)
    assert effective < 0.2 * len(joint)  # neighbours on a curve tell the same


@pytest.fixture(scope="module")
def block() -> tuple[Network, AdjustmentResult]:
    network, _ = simulate_block("six-image-mixed", 2)
    return network, adjust(network)


def codes(result: AdjustmentResult) -> set[str]:
    return {problem.code for problem in result.problems}


def test_right_points_and_splines_pass(block: tuple[Network, AdjustmentResult]) -> None:
    _, result = block
    assert not codes(result) & {"SBB554", "SBB555", "SBB556"}
    assert "SBB553" in codes(result)  # six points are fewer than thirty


def test_one_wrong_point_is_named(block: tuple[Network, AdjustmentResult]) -> None:
    network, _ = block
    row = network.points.ids.index("check-3")
    xyz = network.points.xyz.copy()
    xyz[row, 2] += 0.5  # ten times its predicted sigma
    result = adjust(replace(network, points=replace(network.points, xyz=xyz)))
    assert [point.id for point in result.checks.points if not point.passed] == ["check-3"]
    (problem,) = [problem for problem in result.problems if problem.code == "SBB554"]
    assert "`check-3`" in problem.message


def test_a_small_common_shift_is_found_where_no_single_point_fails(
    block: tuple[Network, AdjustmentResult],
) -> None:
    """Given coordinates 1.8 sigma of a single point beside the adjusted ones, all to the same side."""
    network, before = block
    rows = measured_checks(network)
    xyz = network.points.xyz.copy()
    xyz[rows] = before.points.xyz[rows] - network.origin
    xyz[rows, 0] -= 1.8 * np.mean([point.sigma[0] for point in before.checks.points])
    result = adjust(replace(network, points=replace(network.points, xyz=xyz)))
    assert result.checks.summary is not None and result.checks.summary.beyond == 0
    assert "SBB555" in codes(result)


def test_a_moved_spline_fails_and_a_stated_sigma_excuses_it(block: tuple[Network, AdjustmentResult]) -> None:
    network, _ = block
    moved = tuple(
        replace(curve, check_values=curve.check_values + [0.0, 0.0, 0.3]) if curve.role == "check" else curve
        for curve in network.curves
    )
    result = adjust(replace(network, curves=moved))
    assert "SBB556" in codes(result)
    excused = tuple(replace(curve, check_sigma=0.3) for curve in moved)
    assert "SBB556" not in codes(adjust(replace(network, curves=excused)))


def test_accuracies_hold_that_of_the_given_coordinates() -> None:
    """3 and 4 cm, 12 cm vertically; given to 5 cm horizontally and 5 cm vertically: 13 cm vertically."""
    difference = np.tile([0.03, -0.04, 0.12], (5, 1))
    sigma = np.tile([0.03, 0.04, 0.05], (5, 1))
    found = summary_of(difference, sigma, 0.05, 2.0, 0, None, None)
    assert found.rmse_horizontal == pytest.approx(0.05)
    assert found.accuracy_horizontal == pytest.approx(0.05 * np.sqrt(2.0))
    assert found.accuracy_vertical == pytest.approx(0.13)
    assert found.accuracy_3d == pytest.approx(np.hypot(0.05 * np.sqrt(2.0), 0.13))
    assert found.largest == pytest.approx([0.03, -0.04, 0.12])
