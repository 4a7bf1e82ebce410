"""What a person should know about check points and check splines."""

from __future__ import annotations

from splinebba_cli.core.quality.length_text import length_text
from splinebba_cli.core.result import CheckPointSummary, Checks, CheckSpline, Problem

FEWEST = 30  # check points: ASPRS Positional Accuracy Standards for Digital Geospatial Data, edition 2 (2023)


def check_findings(checks: Checks) -> tuple[Problem, ...]:
    """Problems of the checks, warnings first."""
    found = [] if checks.summary is None else [*_points(checks, checks.summary), *_shift(checks.summary)]
    found += [problem for spline in checks.splines for problem in _spline(spline)]
    if checks.summary is not None and checks.summary.count < FEWEST:
        found.append(_few(checks.summary.count))
    return tuple(found)


def _points(checks: Checks, summary: CheckPointSummary) -> list[Problem]:
    worst = sorted((p for p in checks.points if not p.passed), key=lambda p: -p.normalized)
    together = summary.together
    if not worst and (together is None or together.passed):
        return []
    if worst:
        names = ", ".join(f"`{point.id}`" for point in worst[:6])
        more = f" and {len(worst) - 6} more" if len(worst) > 6 else ""
        differ = "differs" if len(worst) == 1 else "differ"
        points = "check point" if summary.count == 1 else "check points"
        message = (
            f"{len(worst)} of {summary.count} {points} {differ} from what is given by more than the predicted "
            f"precision allows (α = {summary.alpha:g} for all of them): {names}{more}"
        )
    else:
        assert together is not None
        message = (
            f"the {summary.count} check points together differ from what is given by more than predicted: "
            f"d′C⁻¹d = {together.statistic:.1f}, largest accepted {together.critical:.1f}"
        )
    help = (
        "look for wrong coordinates or identifications of single points; if all are affected, the precision is stated "
        "too well: look at the σ of control and of its coordinates, and for systematic image errors"
    )
    return [Problem("SBB554", "warning", message, "check points", help)]


def _shift(summary: CheckPointSummary) -> list[Problem]:
    if summary.shift is None or summary.shift.passed:
        return []
    parts = [f"{axis} {value:+.3g} m" for axis, value in zip("XYZ", summary.mean, strict=True)]
    mean = ", ".join(parts).replace("-", "−")
    message = (
        f"the check points are shifted as a whole: mean difference {mean} (d′C⁻¹d = {summary.shift.statistic:.1f}, "
        f"largest accepted {summary.shift.critical:.1f})"
    )
    help = "control and check points may refer to other datums, heights or epochs; or the principal distance is wrong"
    return [Problem("SBB555", "warning", message, "check points", help)]


def _spline(spline: CheckSpline) -> list[Problem]:
    together = spline.together
    if not spline.beyond and (together is None or together.passed):
        return []
    message = (
        f"check spline `{spline.id}` lies farther from its given shape than predicted: RMS {length_text(spline.rms)}, "
        f"predicted {length_text(spline.sigma_mean * 2**0.5)}, {spline.beyond} points beyond their limit"
    )
    help = (
        "the given points may be less precise than stated (`check_sigma_m`), the knots too far apart for the shape, or "
        "another edge was measured"
    )
    return [Problem("SBB556", "warning", message, f"spline `{spline.id}`", help)]


def _few(count: int) -> Problem:
    points = "check point" if count == 1 else "check points"
    return Problem(
        "SBB553",
        "info",
        f"only {count} {points}: an accuracy according to ASPRS (edition 2, 2023) needs at least {FEWEST}",
        "check points",
        "their RMSE is uncertain: with n points its relative standard deviation is about 1/√(2n) per coordinate",
    )
