"""Whether a result satisfies what its project asks for: one criterion a key of `acceptance`, in their order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from splinebba_cli.core.evidence import Criterion, CriterionStatus
from splinebba_cli.core.result import AdjustmentResult, Problem
from splinebba_cli.project.acceptance_values import (
    Found,
    angle_sigma,
    check_count,
    check_rmse,
    check_rmse_horizontal,
    check_rmse_vertical,
    check_spline_rms,
    mean_redundancy,
    point_sigma,
    position_sigma,
    rejected_share,
    sigma0,
    sigma_across,
    smallest_redundancy,
    standardized,
)
from splinebba_cli.project.model_acceptance import Acceptance


@dataclass(frozen=True)
class _Limit:
    """A criterion with a limit: what it is called and how its value is found."""

    title: str
    unit: str
    value: Callable[[AdjustmentResult], Found]
    largest: bool = True  # whether the limit is an upper one
    nothing: str = "there is nothing to test"


_NO_POINTS = "there are no check points"
_LIMITS: dict[str, _Limit] = {
    "max_sigma0": _Limit("σ̂₀", "", sigma0, nothing="there is no redundancy"),
    "max_standardized": _Limit("largest standardised residual", "", standardized),
    "max_rejected_share": _Limit("share of rejected observations", "", rejected_share),
    "min_redundancy_number": _Limit("smallest redundancy number", "", smallest_redundancy, largest=False),
    "min_mean_redundancy_number": _Limit("mean redundancy number", "", mean_redundancy, largest=False),
    "min_check_points": _Limit("number of check points", "", check_count, largest=False),
    "max_check_rmse_m": _Limit("RMSE of check points", "m", check_rmse, nothing=_NO_POINTS),
    "max_check_rmse_horizontal_m": _Limit(
        "horizontal RMSE of check points", "m", check_rmse_horizontal, nothing=_NO_POINTS
    ),
    "max_check_rmse_vertical_m": _Limit(
        "vertical RMSE of check points", "m", check_rmse_vertical, nothing=_NO_POINTS
    ),
    "max_check_spline_rms_m": _Limit(
        "RMS distance of a check spline", "m", check_spline_rms, nothing="there are no check splines"
    ),
    "max_position_sigma_m": _Limit("σ of a perspective centre", "m", position_sigma),
    "max_angle_sigma_deg": _Limit("σ of an angle", "°", angle_sigma),
    "max_point_sigma_m": _Limit("σ of a point", "m", point_sigma, nothing="there are no estimated points"),
    "max_sigma_across_m": _Limit(
        "σ across a spline", "m", sigma_across, nothing="there are no estimated splines"
    ),
}


def assess(acceptance: Acceptance, result: AdjustmentResult) -> tuple[Criterion, ...]:
    """Every criterion that the project asks for, with what was found."""
    asked = {key: getattr(acceptance, key) for key in type(acceptance).model_fields}
    return tuple(
        _TESTS[key](result) if key in _TESTS else _limited(key, float(value), result)
        for key, value in asked.items()
        if value is not None and value is not False
    )


def violations(criteria: tuple[Criterion, ...]) -> tuple[Problem, ...]:
    """Problems of the criteria that are not satisfied; one that cannot be tested is none of the satisfied ones."""
    return tuple(
        Problem("SBB510", "error", criterion.message, f"acceptance.{criterion.key}")
        for criterion in criteria
        if criterion.status != "passed"
    )


def _limited(key: str, limit: float, result: AdjustmentResult) -> Criterion:
    kind = _LIMITS[key]
    found = kind.value(result)
    unit = f" {kind.unit}" if kind.unit == "m" else kind.unit
    if found.value is None:
        return Criterion(key, kind.title, None, limit, kind.unit, "untested", f"not tested: {kind.nothing}")
    passed = found.value <= limit if kind.largest else found.value >= limit
    about = f"{found.subject}: " if found.subject else ""
    verb = (
        ("is within" if passed else "exceeds") if kind.largest else ("reaches" if passed else "falls below")
    )
    message = f"{about}{kind.title}{found.detail} {found.value:.4g}{unit} {verb} {limit:g}{unit}"
    status: CriterionStatus = "passed" if passed else "failed"
    return Criterion(key, kind.title, found.value, limit, kind.unit, status, message, found.subject)


def _global_test(result: AdjustmentResult) -> Criterion:
    """The chi-square test; its lower bound does not count where the method against outliers reduces weights."""
    test, title = result.statistics.global_test, "global test"
    if test is None:
        return Criterion(
            "global_test", title, None, None, "", "untested", "not tested: there is no redundancy"
        )
    small = test.statistic < test.lower and result.network.settings.outliers.reweights
    passed = test.passed or small
    where = "inside" if test.passed else "outside"
    message = (
        f"the χ² test {'passes' if passed else 'fails'}: {test.statistic:.1f} is {where} of "
        f"{test.lower:.1f} … {test.upper:.1f}"
    )
    if small:
        message = (
            f"the χ² test passes: {test.statistic:.1f} is not above {test.upper:.1f}; the lower bound, "
            f"{test.lower:.1f}, does not count where weights are reduced"
        )
    status: CriterionStatus = "passed" if passed else "failed"
    return Criterion("global_test", title, test.statistic, None, "", status, message)


def _check_tests(result: AdjustmentResult) -> Criterion:
    """All tests of check points and check splines: `value` is the number of those that fail."""
    checks, title = result.checks, "tests of check features"
    failed = [f"point `{point.id}`" for point in checks.points if not point.passed]
    if checks.summary is not None:
        joint = (
            ("check points together", checks.summary.together),
            ("mean of the check points", checks.summary.shift),
        )
        failed += [name for name, test in joint if test is not None and not test.passed]
    for spline in checks.splines:
        if spline.beyond or (spline.together is not None and not spline.together.passed):
            failed.append(f"spline `{spline.id}`")
    if not checks.points and not checks.splines:
        message = "not tested: there are no check points and no check splines"
        return Criterion("check_tests", title, None, None, "", "untested", message)
    if not failed:
        message = "check points and check splines agree with their predicted precision"
        return Criterion("check_tests", title, 0.0, None, "", "passed", message)
    message = f"{len(failed)} tests of check features fail: {', '.join(failed[:6])}{' …' if len(failed) > 6 else ''}"
    return Criterion("check_tests", title, float(len(failed)), None, "", "failed", message, failed[0])


_TESTS: dict[str, Callable[[AdjustmentResult], Criterion]] = {
    "global_test": _global_test,
    "check_tests": _check_tests,
}
