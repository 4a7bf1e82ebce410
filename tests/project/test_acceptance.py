"""Acceptance criteria: each is violated on one side of its limit only."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.result import AdjustmentResult, CheckPoint, Checks, CheckSpline, GlobalTest
from splinebba_cli.project.acceptance import assess, violations
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.model import Acceptance
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


def test_what_cannot_be_tested_is_not_accepted(result: AdjustmentResult) -> None:
    nothing = replace(
        result,
        checks=Checks(),
        statistics=replace(result.statistics, sigma0=float("nan"), global_test=None),
    )
    wanted = {"global_test": True, "max_sigma0": 9, "max_check_rmse_m": 9, "max_check_spline_rms_m": 9}
    found = violations(assess(Acceptance.model_validate(wanted), nothing))
    assert [problem.subject for problem in found] == [f"acceptance.{key}" for key in wanted]
