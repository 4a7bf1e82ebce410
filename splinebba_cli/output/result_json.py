"""result.json: everything but the large tables, format ``splinebba-result/1``.

Metres in the user's object frame, degrees; standard deviations in the same units; NaN is null.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.errors import OutputError
from splinebba_cli.output.checks_json import acceptance_to_list, checks_to_dict, precision_to_dict
from splinebba_cli.output.damaged_results import no_constant, without_acting_characters
from splinebba_cli.output.json_text import finite, json_text
from splinebba_cli.output.local_tests import local_tests_part
from splinebba_cli.output.model_evidence_json import model_evidence
from splinebba_cli.output.residual_summary import residual_summary
from splinebba_cli.output.revision_json import revision_to_dict
from splinebba_cli.output.splines_json import splines_to_list
from splinebba_cli.output.tables import EOP_NAMES
from splinebba_cli.project.diagnostics import listing
from splinebba_cli.project.file_content import NoContentError, file_content

RESULT_FORMAT = "splinebba-result/1"
MOST_SEGMENTS = 5_000  # of all splines; the coefficients of more stand in their table alone
_EOP_KEYS = ("x", "y", "z", "omega", "phi", "kappa")
_EOP_ORDER = (3, 4, 5, 0, 1, 2)


def result_to_dict(result: AdjustmentResult, provenance: dict[str, Any] | None = None) -> dict[str, Any]:
    """The content of result.json.

    Parameters
    ----------
    result : AdjustmentResult
    provenance : dict, optional
        From :func:`splinebba_cli.output.provenance.provenance`.

    Returns
    -------
    dict
        JSON types only; lengths in metres (residuals in the photo: mm and px), angles in degrees.
    """
    with_segments = bool(CurveColumns.of(result.curves).segment_counts.sum() <= MOST_SEGMENTS)
    content = {
        "format": RESULT_FORMAT,
        "provenance": provenance or {},
        "status": {
            "converged": result.converged,
            "termination": result.termination,
            "iterations": len(result.iterations),
        },
        "statistics": _statistics(result),
        "settings": _settings(result),
        "acceptance": acceptance_to_list(result.acceptance),
        "problems": [
            {
                "code": p.code,
                "severity": p.severity,
                "message": p.message,
                "subject": p.subject,
                "help": p.help,
            }
            for p in result.problems
        ],
        "cameras": _cameras(result),
        "images": _images(result),
        "splines": [],  # in their place when all else is finite
        **({} if with_segments else {"segments_table": "spline_coefficients"}),
        "points": _points(result),
        "checks": checks_to_dict(result.checks),
        "precision": precision_to_dict(result.evidence.precision),
        "residuals": residual_summary(result),
        "tests": local_tests_part(result),
        **model_evidence(result.evidence),
        "revision": revision_to_dict(result),
        "convergence": [
            {"stage": i.stage, "iteration": i.number, "cost": i.cost, "step": i.step, "damping": i.damping}
            for i in result.iterations
        ],
    }
    return {**finite(content), "splines": splines_to_list(result, with_segments)}


def result_json_text(content: dict[str, Any]) -> str:
    """The bytes of result.json as text; the same content gives the same text."""
    return json_text(content)


def _where_results_are(path: Path) -> str:
    """A help line: the result folders inside a folder that is none, a project's for example."""
    inside = sorted(file.parent.name for file in path.glob("*/result.json")) if path.is_dir() else []
    if not inside:
        return "give a folder that `adjust` wrote"
    return f"results lie in {listing(str(path / name) for name in inside)}"


def load_result_json(path: Path) -> dict[str, Any]:
    """Read result.json, or the result.json of a result folder.

    Raises
    ------
    OutputError
        SBB602 if there is none, or it is not of format ``splinebba-result/1``.
    """
    file = path / "result.json" if path.is_dir() else path
    try:
        text = file_content(file).decode("utf-8")
        content = without_acting_characters(json.loads(text, parse_constant=no_constant), text)
    except (NoContentError, ValueError, RecursionError) as error:
        raise OutputError(
            "SBB602", f"{path} holds no readable result.json", _where_results_are(path)
        ) from error
    if not isinstance(content, dict) or content.get("format") != RESULT_FORMAT:
        raise OutputError(
            "SBB602", f"{file} is not of format {RESULT_FORMAT}", "run `splinebba adjust` again"
        )
    return content


def _statistics(result: AdjustmentResult) -> dict[str, Any]:
    s = result.statistics
    test = s.global_test
    return {
        "observations": s.observations,
        "unknowns": s.unknowns,
        "conditions": s.conditions,
        "rank_defect": s.rank_defect,
        "redundancy": s.redundancy,
        "sum_redundancy_numbers": s.sum_redundancy_numbers,
        "condition_redundancy": s.condition_redundancy,
        "condition_cost": s.condition_cost,
        "vtpv": s.vtpv,
        "sigma0_prior": s.sigma0_prior,
        "sigma0": s.sigma0,
        "global_test": None
        if test is None
        else {
            "statistic": test.statistic,
            "lower": test.lower,
            "upper": test.upper,
            "alpha": test.alpha,
            "passed": bool(test.passed),
        },
    }


def _settings(result: AdjustmentResult) -> dict[str, Any]:
    s = result.network.settings
    return {
        "datum": s.datum,
        "alpha": s.alpha,
        "sigmas_scaled_by_sigma0": s.scale_dispersion,
        "gauge_sigma_m": s.gauge_sigma_m,
        "local_origin": result.network.origin,
    }


def _cameras(result: AdjustmentResult) -> list[dict[str, Any]]:
    return [
        {
            "id": c.id,
            "principal_distance_mm": c.principal_distance_mm,
            "principal_point_mm": c.principal_point_mm,
            "radial": c.radial,
            "decentring": c.decentring,
            "affinity": c.affinity,
            "pixel_size_mm": c.pixel_size_mm,
            "format_mm": None if c.format_mm is None else list(c.format_mm),
        }
        for c in result.network.cameras
    ]


def _images(result: AdjustmentResult) -> list[dict[str, Any]]:
    images = result.network.images
    scale = np.where(np.arange(6) < 3, 180.0 / np.pi, 1.0)
    eop = (result.images.eop * scale).tolist()
    sigma = (_sigma(result.images.dispersion) * scale).tolist()
    rows = []
    for i, name in enumerate(images.ids):
        values = {key: eop[i][j] for key, j in zip(_EOP_KEYS, _EOP_ORDER, strict=True)}
        rows.append(
            {
                "id": name,
                "camera": result.network.cameras[int(images.camera[i])].id,
                "rotation_sequence": images.sequence[i],
                **values,
                "sigma": {key: sigma[i][j] for key, j in zip(_EOP_KEYS, _EOP_ORDER, strict=True)},
                "fixed": [EOP_NAMES[j] for j in range(6) if not result.images.estimated[i, j]],
                "correlations": _strong_correlations(
                    result.images.dispersion[i], result.network.settings.correlation_threshold
                ),
            }
        )
    return rows


def _strong_correlations(dispersion: FloatArray, threshold: float) -> list[dict[str, Any]]:
    """Pairs of exterior orientation parameters with |r| beyond the threshold, strongest first."""
    sigma = np.sqrt(np.maximum(np.diag(dispersion), 0.0))
    pairs = []
    for i in range(6):
        for j in range(i + 1, 6):
            if sigma[i] > 0.0 and sigma[j] > 0.0:
                r = float(dispersion[i, j] / (sigma[i] * sigma[j]))
                if abs(r) > threshold:
                    pairs.append({"a": EOP_NAMES[i], "b": EOP_NAMES[j], "r": r})
    return sorted(pairs, key=lambda pair: -abs(float(str(pair["r"]))))


def _sigma(dispersion: FloatArray) -> FloatArray:
    """Square roots of the diagonals, (n, k) of (n, k, k); tiny negative rounding becomes 0."""
    return np.asarray(np.sqrt(np.maximum(np.einsum("nii->ni", dispersion), 0.0)))


def _points(result: AdjustmentResult) -> list[dict[str, Any]]:
    sigma = _sigma(result.points.dispersion).tolist()
    xyz, rays = result.points.xyz.tolist(), result.points.rays.tolist()
    return [
        {
            "id": name,
            "role": role,
            **dict(zip("xyz", xyz[i], strict=True)),
            "sigma": dict(zip("xyz", sigma[i], strict=True)),
            "rays": rays[i],
        }
        for i, (name, role) in enumerate(
            zip(result.network.points.ids, result.network.points.role, strict=True)
        )
    ]
