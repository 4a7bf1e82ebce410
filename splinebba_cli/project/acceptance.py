"""Whether a result satisfies what its project asks for."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.result import AdjustmentResult, Problem
from splinebba_cli.project.model import Acceptance


def violations(acceptance: Acceptance, result: AdjustmentResult) -> tuple[Problem, ...]:
    """Criteria of the project that a result does not satisfy.

    A criterion that cannot be tested (no redundancy, no check points) counts as violated.
    """
    found = []
    statistics = result.statistics
    if acceptance.global_test:
        test = statistics.global_test
        if test is None:
            found.append(_untested("acceptance.global_test", "there is no redundancy"))
        elif not test.passed:
            message = (
                f"the χ² test fails: {test.statistic:.1f} is outside of {test.lower:.1f} … {test.upper:.1f}"
            )
            found.append(_problem("acceptance.global_test", message))
    if acceptance.max_sigma0 is not None and not statistics.sigma0 <= acceptance.max_sigma0:
        message = f"σ̂₀ {statistics.sigma0:.4g} exceeds {acceptance.max_sigma0:g}"
        found.append(_problem("acceptance.max_sigma0", message))
    limit = acceptance.max_check_rmse_m
    if limit is not None:
        differences = np.array([point.difference for point in result.checks.points]).reshape(-1, 3)
        if not len(differences):
            found.append(_untested("acceptance.max_check_rmse_m", "there are no check points"))
        for name, rmse in zip(
            "XYZ", np.sqrt(np.mean(differences**2, axis=0)) if len(differences) else [], strict=False
        ):
            if not rmse <= limit:
                message = f"RMSE of check points in {name} {rmse:.4g} m exceeds {limit:g} m"
                found.append(_problem("acceptance.max_check_rmse_m", message))
    limit = acceptance.max_check_spline_rms_m
    if limit is not None:
        if not result.checks.splines:
            found.append(_untested("acceptance.max_check_spline_rms_m", "there are no check splines"))
        for spline in result.checks.splines:
            if not spline.rms <= limit:
                message = f"check spline `{spline.id}`: RMS distance {spline.rms:.4g} m exceeds {limit:g} m"
                found.append(_problem("acceptance.max_check_spline_rms_m", message))
    limit = acceptance.max_position_sigma_m
    if limit is not None:
        variances = np.diagonal(result.images.dispersion, axis1=1, axis2=2)[:, 3:]
        worst = np.sqrt(variances.max(axis=1, initial=0.0))
        for number in np.flatnonzero(~(worst <= limit)):
            name = result.network.images.ids[number]
            message = f"image `{name}`: σ of the perspective centre {worst[number]:.4g} m exceeds {limit:g} m"
            found.append(_problem("acceptance.max_position_sigma_m", message))
    return tuple(found)


def _problem(subject: str, message: str) -> Problem:
    return Problem("SBB510", "error", message, subject)


def _untested(subject: str, reason: str) -> Problem:
    return Problem("SBB510", "error", f"not tested: {reason}", subject)
