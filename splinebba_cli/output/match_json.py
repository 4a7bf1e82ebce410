"""match.json, format ``splinebba-match/1``: what was matched, how it came about, what is left; metres and degrees."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from splinebba_cli.core.evidence import Criterion, CriterionStatus
from splinebba_cli.core.matching.matches import BuiltCurve, MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import FloatArray
from splinebba_cli.errors import OutputError
from splinebba_cli.output.checks_json import acceptance_to_list
from splinebba_cli.output.damaged_results import no_constant, without_acting_characters
from splinebba_cli.output.json_text import finite
from splinebba_cli.output.match_counts import BINS, CLEAR, MatchCounts
from splinebba_cli.project.file_content import NoContentError, file_content
from splinebba_cli.project.matched import images_kept
from splinebba_cli.project.matched_tables import reason_word
from splinebba_cli.project.network_tables import orientations

MATCH_FORMAT = "splinebba-match/1"
MATCH_FILE = "match.json"
_EOP = ("x", "y", "z", "omega", "phi", "kappa")
_ORDER = (3, 4, 5, 0, 1, 2)  # of the dispersion: omega, phi, kappa, X0, Y0, Z0


def match_content(
    result: MatchResult,
    settings: MatchSettings,
    provenance: Mapping[str, Any],
    min_matched_share: float | None = None,
) -> dict[str, Any]:
    """The content of match.json.

    Parameters
    ----------
    min_matched_share : float, optional
        Smallest share of points with a label, of this matching or from before, that the project accepts.
    """
    counts = MatchCounts(result)
    content = {
        "format": MATCH_FORMAT,
        "provenance": dict(provenance),
        "settings": _settings(settings),
        "acceptance": _acceptance(counts, min_matched_share),
        "counts": _counts(counts),
        "reasons": {reason_word(reason): number for reason, number in counts.by_reason().items()},
        "ambiguity": _ambiguity(counts),
        "images": _images(counts),
        "splines": _splines(counts),
        "history": [_step(step) for step in result.history],
        "new_splines": [_built(each, result) for each in result.built],
        "problems": [asdict(problem) for problem in result.problems],
    }
    cleaned: dict[str, Any] = finite(content)
    return cleaned


def _settings(settings: MatchSettings) -> dict[str, Any]:
    """Settings under the names of the project file, angles in degrees."""
    values = asdict(settings)
    angle, direction = values.pop("angle_sigma_rad"), values.pop("direction_tolerance_rad")
    values["knot_tolerance_sigma"] = values.pop("knot_tolerance")
    values["angle_sigma_deg"] = None if angle is None else math.degrees(angle)
    values["direction_tolerance_deg"] = math.degrees(direction)
    return dict(sorted(values.items()))


def _acceptance(counts: MatchCounts, smallest: float | None) -> list[dict[str, Any]]:
    """The criterion of the project, if it has one, as result.json has them."""
    if smallest is None:
        return []
    share = counts.labelled_share
    passed = share >= smallest
    before = f", {counts.labelled_before} of them before" if counts.labelled_before else ""
    found = f"{100 * share:.1f} % of the image points were matched{before}"
    message = f"{found}, at least {100 * smallest:g} % are asked for"
    status: CriterionStatus = "passed" if passed else "failed"
    criterion = Criterion(
        "min_matched_share", "share of matched image points", share, smallest, "", status, message
    )
    return acceptance_to_list((criterion,))


def _counts(counts: MatchCounts) -> dict[str, Any]:
    result = counts.result
    size, matched = counts.chain_sizes
    total = int(counts.counted.sum())
    return {
        "points": total,
        "matched": int((counts.matched & counts.counted).sum()),
        "share": counts.share,
        "excluded": len(counts.counted) - total,
        "labelled_before": counts.labelled_before,
        "chains": len(size),
        "chains_matched_whole": int(((matched == size) & (size > 0)).sum()),
        "chains_matched_in_part": int(((matched > 0) & (matched < size)).sum()),
        "chains_unmatched": int((matched == 0).sum()),
        "images": len(result.given.images.ids),
        "images_oriented": int(result.oriented.sum()),
        "splines": len(result.given.curves),
        "new_splines": len(result.built),
    }


def _ambiguity(counts: MatchCounts) -> dict[str, Any]:
    """Histogram of the distance over that of the second-best spline, of the matched points that have one near."""
    near = counts.matched & np.isfinite(counts.result.matches.runner_up)
    numbers, edges = np.histogram(counts.ratio[near], bins=BINS, range=(0.0, 1.0))
    return {
        "alone": int(counts.matched.sum() - near.sum()),
        "edges": edges,
        "points": numbers,
        "close": int((counts.ratio[near] > CLEAR).sum()),
        "close_from": CLEAR,
    }


def _images(counts: MatchCounts) -> list[dict[str, Any]]:
    result = counts.result
    given, found = result.given.images, result.network.images
    points, matched = counts.per_image()
    kept = images_kept(result.network)
    eop = orientations(found, result.network.origin, "deg")
    variance = np.einsum("mii->mi", result.eop_dispersion)
    sigma = np.sqrt(np.maximum(variance, 0.0)) * np.where(np.arange(6) < 3, 180.0 / np.pi, 1.0)
    moved = np.linalg.norm(found.position - given.position, axis=1)
    turned = _turns(given.rotation, found.rotation)
    rows = []
    for k, name in enumerate(given.ids):
        own = result.given.unlabelled.image == k
        why = counts.by_reason(own)
        rows.append(
            {
                "id": name,
                "points": int(points[k]),
                "matched": int(matched[k]),
                "share": float(matched[k] / points[k]) if points[k] else None,
                "reasons": {reason_word(reason): number for reason, number in why.items()},
                "oriented": bool(result.oriented[k]),
                "in_matched_project": bool(kept[k]),
                **dict(zip(_EOP, eop[k].tolist(), strict=True)),
                "sigma": dict(zip(_EOP, sigma[k, list(_ORDER)].tolist(), strict=True)),
                "moved_m": float(moved[k]),
                "turned_deg": float(turned[k]),
            }
        )
    return rows


def _turns(before: FloatArray, after: FloatArray) -> FloatArray:
    """Angles between two orientations, (m,) degrees; NaN where either is unknown."""
    out = np.full(len(before), np.nan)
    known = np.isfinite(before).all(axis=(1, 2)) & np.isfinite(after).all(axis=(1, 2))
    if known.any():
        out[known] = np.degrees(
            (Rotation.from_matrix(after[known]) * Rotation.from_matrix(before[known]).inv()).magnitude()
        )
    return out


def _splines(counts: MatchCounts) -> list[dict[str, Any]]:
    result = counts.result
    points, images, chains = counts.per_curve()
    built = {each.curve for each in result.built}
    squares = np.zeros(len(result.network.curves))
    rows = counts.matched & np.isfinite(result.matches.distance)
    np.add.at(squares, result.matches.curve[rows], result.matches.distance[rows] ** 2)
    return [
        {
            "id": curve.id,
            "role": curve.role,
            "new": k in built,
            "points": int(points[k]),
            "images": int(images[k]),
            "chains": int(chains[k]),
            "rms_distance": math.sqrt(squares[k] / points[k]) if points[k] else None,
        }
        for k, curve in enumerate(result.network.curves)
    ]


def _step(step: Any) -> dict[str, Any]:
    values = asdict(step)
    values["angle_step_deg"] = math.degrees(values.pop("angle_step_rad"))
    return values


def _built(each: BuiltCurve, result: MatchResult) -> dict[str, Any]:
    points, curve = result.given.unlabelled, result.network.curves[each.curve]
    return {
        "id": curve.id,
        "knots": len(curve.values),
        "closed": curve.closed,
        "images": [result.given.images.ids[k] for k in each.images.tolist()],
        "chains": [points.chain_ids[k] for k in each.chains.tolist()],
        "length_m": each.length_m,
        "length_in_three_images_m": each.length_in_three_images_m,
        "weak_parts": [asdict(part) for part in each.weak_parts],
    }


def load_match_json(folder: Path) -> dict[str, Any]:
    """Read the match.json of a folder that `match` wrote.

    Raises
    ------
    OutputError
        SBB602 if there is none, or it is not of format ``splinebba-match/1``.
    """
    file = folder / MATCH_FILE
    try:
        text = file_content(file).decode("utf-8")
        content = without_acting_characters(json.loads(text, parse_constant=no_constant), text)
    except (NoContentError, ValueError, RecursionError) as error:
        raise OutputError(
            "SBB602", f"{folder} holds no readable {MATCH_FILE}", "run `splinebba match`"
        ) from error
    if not isinstance(content, dict) or content.get("format") != MATCH_FORMAT:
        raise OutputError("SBB602", f"{file} is not of format {MATCH_FORMAT}", "run `splinebba match` again")
    return content
