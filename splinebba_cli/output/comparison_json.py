"""A comparison as plain data: what ``compare --format json`` prints.  Metres, degrees; NaN is null."""

from __future__ import annotations

from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.parameter_test import RatioTest
from splinebba_cli.output.comparison import Comparison
from splinebba_cli.output.comparison_differences import Differences
from splinebba_cli.output.json_text import finite
from splinebba_cli.output.stored_result import StoredResult

COMPARISON_FORMAT = "splinebba-comparison/1"
_EOP = ("omega", "phi", "kappa", "x", "y", "z")
_STATISTICS = ("observations", "unknowns", "conditions", "redundancy", "vtpv", "sigma0_prior", "sigma0")


def comparison_to_dict(found: Comparison) -> dict[str, Any]:
    """Provenance, statistics, tests, differences: the largest first."""
    content = {
        "format": COMPARISON_FORMAT,
        "significant": found.significant,
        "alpha": found.alpha,
        "results": {"a": _result(found.a), "b": _result(found.b)},
        "inputs": found.inputs,
        "relation": {
            "name": found.relation.name,
            "reason": found.relation.reason,
            "explanation": found.relation.explanation,
            "less_precise": found.relation.less_precise,
            "shared_image_points": found.relation.shared,
            "only_a": found.relation.only_a,
            "only_b": found.relation.only_b,
        },
        "variance_test": _ratio(found.variance_test),
        "model_test": _ratio(found.model_test),
        "similarity": _similarity(found),
        "images": _differences(found.images, _EOP, np.where(np.arange(6) < 3, 180.0 / np.pi, 1.0)),
        "points": _differences(found.points, ("x", "y", "z"), np.ones(3)),
        "splines": [
            {
                "id": each.id,
                "samples": each.count,
                "rms_m": each.rms,
                "max_m": each.largest,
                "sigma_m": each.sigma_rms,
                "normalized_max": each.normalized,
                "probability": each.probability,
                "significant": each.significant,
            }
            for each in sorted(found.splines, key=lambda each: -each.largest)
        ],
        "problems": [
            {
                "code": p.code,
                "severity": p.severity,
                "message": p.message,
                "subject": p.subject,
                "help": p.help,
            }
            for p in found.problems
        ],
    }
    return dict(finite(content))


def order_of(found: Differences) -> list[int]:
    """Rows, the most significant and then the largest first."""
    size = np.nanmax(np.abs(found.difference[:, -3:]), axis=1, initial=0.0)
    standard = np.nanmax(np.nan_to_num(np.abs(found.standardized)), axis=1, initial=0.0)
    probability = np.nan_to_num(found.probability, nan=1.0)
    return [int(row) for row in np.lexsort((-size, -standard, probability))]


def _result(result: StoredResult) -> dict[str, Any]:
    provenance, statistics = result.content["provenance"], result.content["statistics"]
    test = statistics["global_test"]
    return {
        "folder": str(result.folder),
        "project": provenance.get("project", {}).get("name", ""),
        "program": provenance.get("program", {}).get("version", ""),
        "datum": result.content["settings"]["datum"],
        **{key: statistics[key] for key in _STATISTICS},
        "global_test_passed": None if test is None else test["passed"],
    }


def _ratio(test: RatioTest | None) -> dict[str, Any] | None:
    if test is None:
        return None
    return {
        "statistic": test.statistic,
        "degrees": [test.numerator, test.denominator],
        "lower": test.lower,
        "upper": test.upper,
        "alpha": test.alpha,
        "probability": test.probability,
        "significant": test.significant,
    }


def _similarity(found: Comparison) -> dict[str, Any] | None:
    similarity = found.similarity
    if similarity is None:
        return None
    return {
        "scale_ppm": 1e6 * (similarity.scale - 1.0),
        "rotation_deg": np.degrees(similarity.angles),
        "translation_m": similarity.translation,
        "rms_m": similarity.rms,
        "points": similarity.count,
    }


def _differences(found: Differences, names: tuple[str, ...], scale: FloatArray) -> dict[str, Any]:
    difference, sigma, standardized = found.difference * scale, found.sigma * scale, found.standardized
    return {
        "common": len(found.ids),
        "only_a": list(found.only_a),
        "only_b": list(found.only_b),
        "significant": int(found.significant.sum()),
        "differences": [
            {
                "id": found.ids[row],
                **dict(zip(names, difference[row].tolist(), strict=True)),
                "sigma": dict(zip(names, sigma[row].tolist(), strict=True)),
                "standardized": dict(zip(names, standardized[row].tolist(), strict=True)),
                "statistic": float(found.statistic[row]),
                "dimensions": int(found.dimensions[row]),
                "probability": float(found.probability[row]),
                "significant": bool(found.significant[row]),
            }
            for row in order_of(found)
        ],
    }
