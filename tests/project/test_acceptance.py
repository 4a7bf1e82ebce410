"""Acceptance criteria: each is violated on one side of its limit only."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import Criterion, Rejection, Revision
from splinebba_cli.core.result import AdjustmentResult, CheckPoint, Checks, CheckSpline, GlobalTest
from splinebba_cli.project.acceptance import assess, violations
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.model import Acceptance
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.project.project_text import written
from tests.project.small_result import result_of


@pytest.fixture
def result(tmp_path: Path) -> AdjustmentResult:
    bare = result_of(load_project(written(tmp_path)).network)
    dispersion = np.tile(np.diag([9.0, 9.0, 9.0, 0.01, 0.04, 0.0]), (2, 1, 1))
    checks = Checks(
        (
            CheckPoint("a", np.array([0.1, 0.0, 0.3]), np.ones(3), 1.0),
            CheckPoint("b", np.array([-0.1, 0.0, 0.4]), np.ones(3), 1.0),
        ),
        (CheckSpline("s", np.ones(3), 0.25, 0.5, 0.1),),
    )
    return replace(
        bare,
        statistics=replace(
            bare.statistics, sigma0=1.5, global_test=GlobalTest(300.0, 80.0, 120.0, 0.05, False)
        ),
        images=replace(bare.images, dispersion=dispersion),
        checks=checks,
    )


@pytest.mark.parametrize(
    ("criterion", "kept", "violated"),
    [
        ("max_sigma0", 1.5, 1.49),
        ("max_check_rmse_m", 0.354, 0.353),  # sqrt((0.3² + 0.4²) / 2) in Z
        ("max_check_spline_rms_m", 0.25, 0.24),
        ("max_position_sigma_m", 0.2, 0.19),
        ("max_check_rmse_horizontal_m", 0.101, 0.099),  # 0.1 in X
        ("max_check_rmse_vertical_m", 0.354, 0.353),
        ("max_angle_sigma_deg", 171.9, 171.8),  # 3 rad
        ("min_check_points", 2, 3),
    ],
)
def test_limits(criterion: str, kept: float, violated: float, result: AdjustmentResult) -> None:
    assert violations(assess(Acceptance.model_validate({criterion: kept}), result)) == ()
    found = violations(assess(Acceptance.model_validate({criterion: violated}), result))
    assert {(problem.code, problem.subject) for problem in found} == {("SBB510", f"acceptance.{criterion}")}


def test_global_test(result: AdjustmentResult) -> None:
    wanted = Acceptance.model_validate({"global_test": True})
    assert len(violations(assess(wanted, result))) == 1
    passed = replace(result.statistics, global_test=GlobalTest(100.0, 80.0, 120.0, 0.05, True))
    assert violations(assess(wanted, replace(result, statistics=passed))) == ()
    assert violations(assess(Acceptance(), result)) == ()


@pytest.mark.parametrize(
    ("statistic", "method", "status"),
    [
        (70.0, "none", "failed"),
        (70.0, "snooping", "failed"),
        (70.0, "huber", "passed"),  # reduced weights alone make it small
        (130.0, "huber", "failed"),
        (100.0, "huber", "passed"),
    ],
)
def test_lower_bound_of_the_global_test_does_not_count_where_weights_are_reduced(
    statistic: float, method: Literal["none", "snooping", "huber"], status: str, result: AdjustmentResult
) -> None:
    settings = result.network.settings
    test = GlobalTest(statistic, 80.0, 120.0, 0.05, 80.0 <= statistic <= 120.0)
    found = one(
        replace(
            result,
            network=replace(
                result.network,
                settings=replace(settings, outliers=replace(settings.outliers, method=method)),
            ),
            statistics=replace(result.statistics, global_test=test),
        ),
        global_test=True,
    )
    assert found.status == status
    assert ("does not count" in found.message) == (statistic < 80.0 and status == "passed")


def test_what_cannot_be_tested_is_not_accepted(result: AdjustmentResult) -> None:
    nothing = replace(
        result,
        checks=Checks(),
        statistics=replace(result.statistics, sigma0=float("nan"), global_test=None),
    )
    wanted = {"global_test": True, "max_sigma0": 9, "max_check_rmse_m": 9, "max_check_spline_rms_m": 9}
    found = violations(assess(Acceptance.model_validate(wanted), nothing))
    assert [problem.subject for problem in found] == [f"acceptance.{key}" for key in wanted]


@pytest.fixture(scope="module")
def block() -> AdjustmentResult:
    return adjust(simulate_block("six-image-mixed", 2)[0])


def one(result: AdjustmentResult, **criterion: object) -> Criterion:
    (found,) = assess(Acceptance.model_validate(criterion), result)
    return found


def test_largest_standardized_residual_names_its_observation(block: AdjustmentResult) -> None:
    found = one(block, max_standardized=1.0)
    every = [np.nanmax(np.abs(t.standardized)) for t in (block.point_residuals, block.curve_residuals)]
    assert found.value == pytest.approx(max(every))
    assert found.status == "failed" and "in image" in found.subject
    testing = replace(block.network.settings.testing, statistic="tau")
    tau = replace(
        block, network=replace(block.network, settings=replace(block.network.settings, testing=testing))
    )
    assert one(tau, max_standardized=1.0).value == pytest.approx(max(every) / block.statistics.sigma0)


def test_redundancy_numbers_of_observations_that_take_part(block: AdjustmentResult) -> None:
    numbers = np.concatenate(
        [block.point_residuals.redundancy.ravel(), block.curve_residuals.redundancy[:, 0]]
    )
    found, points = one(block, min_redundancy_number=0.5), block.network.point_observations
    assert found.value == pytest.approx(numbers.min())
    row = int(block.point_residuals.redundancy.min(axis=1).argmin())
    image, point = block.network.images.ids[points.image[row]], block.network.points.ids[points.point[row]]
    assert found.subject == f"point `{point}` in image `{image}`"
    assert one(block, min_mean_redundancy_number=0.1).status == "passed"
    weights = np.where(block.curve_residuals.redundancy[:, 0] < 0.3, 0.0, 1.0)
    of_points = np.where(block.point_residuals.redundancy.min(axis=1) < 0.3, 0.0, 1.0)
    revised = replace(block, revision=Revision(curve_weights=weights, point_weights=of_points))
    assert one(revised, min_redundancy_number=0.3).status == "passed"


def test_share_of_rejected_observations(block: AdjustmentResult) -> None:
    rejection = Rejection("point", 0, "point", 1, "w", 5.0, 5.0, 0.02)
    revised = replace(block, revision=Revision(rejections=(rejection, replace(rejection, returned=True))))
    count = len(block.network.point_observations) + len(block.network.curve_observations)
    found = one(revised, max_rejected_share=0.5 / count)
    assert found.status == "failed" and found.value == pytest.approx(1.0 / count)
    assert one(block, max_rejected_share=0).status == "passed"


def test_check_tests(block: AdjustmentResult) -> None:
    assert one(block, check_tests=True).status == "passed"
    wrong = replace(block.checks.points[1], passed=False)
    points = (block.checks.points[0], wrong, *block.checks.points[2:])
    failed = one(replace(block, checks=replace(block.checks, points=points)), check_tests=True)
    assert failed.status == "failed" and failed.subject == f"point `{wrong.id}`"
    assert one(replace(block, checks=Checks()), check_tests=True).status == "untested"


def test_points_and_splines(block: AdjustmentResult) -> None:
    roles = np.array([role != "control" for role in block.network.points.role])
    sigma = np.sqrt(np.einsum("nii->ni", block.points.dispersion))[roles].max()
    assert one(block, max_point_sigma_m=1.0).value == pytest.approx(sigma)
    across = max(curve.sigma_across_max for curve in block.curves)
    assert one(block, max_sigma_across_m=1.0).value == pytest.approx(across)


def test_criteria_keep_their_order_and_all_are_listed(block: AdjustmentResult) -> None:
    wanted = {"max_check_rmse_m": 9, "global_test": True, "max_sigma0": 9, "min_check_points": 30}
    found = assess(Acceptance.model_validate(wanted), block)
    assert [(each.key, each.status) for each in found] == [
        ("global_test", "passed"),
        ("max_sigma0", "passed"),
        ("min_check_points", "failed"),
        ("max_check_rmse_m", "passed"),
    ]
