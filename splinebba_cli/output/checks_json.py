"""Parts of result.json: check features, precision with a confidence, acceptance criteria."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from splinebba_cli.core.evidence import Criterion, ErrorEllipses, Precision
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.result import Checks, CheckTest

LISTED = 20  # ellipses of the worst positions; all of them are in error_ellipses.csv


def checks_to_dict(checks: Checks) -> dict[str, Any]:
    """`checks`: differences and tests of check points and check splines, metres."""
    summary = checks.summary
    rms = np.full(3, np.nan) if summary is None else summary.rmse
    if summary is None and checks.points:
        rms = np.sqrt(np.mean(np.array([point.difference for point in checks.points]) ** 2, axis=0))
    content: dict[str, Any] = {
        "points": [
            {
                "id": point.id,
                "difference": _xyz(point.difference),
                "sigma": _xyz(point.sigma),
                "normalized": point.normalized,
                "passed": point.passed,
            }
            for point in checks.points
        ],
        "points_rms": _xyz(rms),
        "splines": [
            {
                "id": spline.id,
                "n": int(np.isfinite(spline.distance).sum()),
                "rms": spline.rms,
                "mean": spline.mean,
                "max": spline.largest,
                "sigma_mean": spline.sigma_mean,
                "shift": _xyz(spline.shift),
                "critical": spline.critical,
                "beyond": spline.beyond,
                "together": _test(spline.together),
                "distance": spline.distance,
                "normalized": spline.normalized,
            }
            for spline in checks.splines
        ],
    }
    if summary is not None:
        content["points_summary"] = {
            "count": summary.count,
            "rmse": {
                **_xyz(summary.rmse),
                "horizontal": summary.rmse_horizontal,
                "vertical": summary.rmse_vertical,
            },
            "mean": _xyz(summary.mean),
            "largest": _xyz(summary.largest),
            "given": {"horizontal": summary.given_horizontal, "vertical": summary.given_vertical},
            "accuracy": {
                "horizontal": summary.accuracy_horizontal,
                "vertical": summary.accuracy_vertical,
                "3d": summary.accuracy_3d,
            },
            "alpha": summary.alpha,
            "critical": summary.critical,
            "beyond": summary.beyond,
            "together": _test(summary.together),
            "shift": _test(summary.shift),
        }
    return content


def precision_to_dict(precision: Precision | None) -> dict[str, Any] | None:
    """`precision`: factors, the worst positions, the highest correlations."""
    if precision is None:
        return None
    return {
        "confidence": precision.confidence,
        "degrees": precision.degrees,
        "interval_factor": precision.interval_factor,
        "ellipse_factor": precision.ellipse_factor,
        "ellipsoid_factor": precision.ellipsoid_factor,
        "images": _ellipses(precision.images),
        "points": _ellipses(precision.points),
        "correlation_threshold": precision.correlation_threshold,
        "correlations_found": precision.correlations_found,
        "correlations": [
            {"first": pair.first, "second": pair.second, "r": pair.correlation}
            for pair in precision.correlations
        ],
    }


def _ellipses(found: ErrorEllipses) -> dict[str, Any]:
    """Largest and mean figures and the worst positions, by their horizontal radius."""
    worst = np.argsort(-found.horizontal_m, kind="stable")[:LISTED]
    mean = [float(np.sqrt(np.mean(v**2))) if len(v) else None for v in (found.horizontal_m, found.vertical_m)]
    return {
        "count": len(found),
        "horizontal_rms_m": mean[0],
        "vertical_rms_m": mean[1],
        "worst": [
            {
                "id": found.ids[row],
                "semi_axes_m": found.semi_axes_m[row],
                "azimuth_deg": float(np.degrees(found.azimuth_rad[row])),
                "ellipsoid_m": found.ellipsoid_m[row],
                "horizontal_m": float(found.horizontal_m[row]),
                "vertical_m": float(found.vertical_m[row]),
            }
            for row in worst
        ],
    }


def acceptance_to_list(criteria: Sequence[Criterion]) -> list[dict[str, Any]]:
    """`acceptance`: every criterion of the project with what was found."""
    return [
        {
            "criterion": each.key,
            "title": each.title,
            "value": each.value,
            "limit": each.limit,
            "unit": each.unit,
            "status": each.status,
            "message": each.message,
            "subject": each.subject,
        }
        for each in criteria
    ]


def _test(test: CheckTest | None) -> dict[str, Any] | None:
    if test is None:
        return None
    return {
        "statistic": test.statistic,
        "degrees": test.degrees,
        "critical": test.critical,
        "passed": test.passed,
    }


def _xyz(values: FloatArray) -> dict[str, float]:
    return dict(zip("xyz", values.tolist(), strict=True))
