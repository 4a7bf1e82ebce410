"""campaign.json: what a Monte Carlo campaign found, format ``splinebba-campaign/1``.

Metres and degrees.  A ``figure`` is {value, lower, upper, inside}: the interval is the one in which a correct program
finds the value with 99 % probability.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from splinebba_cli.core.network import Network
from splinebba_cli.errors import ERROR_CODES
from splinebba_cli.output.json_text import finite
from splinebba_cli.simulation.campaign_statistics import (
    HISTOGRAM_EDGES,
    ElementStatistics,
    KindStatistics,
    SplineStatistics,
    StudyStatistics,
    all_elements,
    all_locations,
    all_splines,
    failures_by_code,
    histogram,
    kind_statistics,
    largest_bias,
    study_statistics,
)
from splinebba_cli.simulation.intervals import CONFIDENCE, Figure
from splinebba_cli.simulation.monte_carlo import MonteCarloResult, summarize
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.run_errors import given_locations
from splinebba_cli.simulation.run_record import Failure, RunRecord

CAMPAIGN_FORMAT = "splinebba-campaign/1"
_EOP = ("omega", "phi", "kappa", "x", "y", "z")
_DEGREES = float(np.degrees(1.0))


@dataclass(frozen=True)
class CampaignInput:
    """What a campaign was."""

    network: Network  # of the design
    noise: Noise
    identity: Mapping[str, Any]  # target, inputs, options, program: as in the file of runs
    runs: int  # asked for
    confidence: float


def campaign_content(campaign: CampaignInput, records: Sequence[RunRecord]) -> dict[str, Any]:
    """The content of campaign.json.

    Returns
    -------
    dict
        JSON types only; ``statistics`` is None where no run was solved.
    """
    failures = [record.failure for record in records if record.failure is not None]
    settings = campaign.network.settings
    solved = len(records) - len(failures)
    statistics = None
    if solved:
        result = summarize(records, settings.alpha, settings.scale_dispersion)
        statistics = _statistics(campaign, result)
    content = {
        "format": CAMPAIGN_FORMAT,
        **campaign.identity,
        "confidence": campaign.confidence,
        "interval": CONFIDENCE,
        "runs": {
            "asked": campaign.runs,
            "finished": len(records),
            "solved": solved,
            "failed": len(failures),
            "reasons": _reasons(failures_by_code(failures)),
        },
        "statistics": statistics,
        "study": [_study(each, campaign.noise) for each in study_statistics(records)],
    }
    return dict(finite(content))


def _statistics(campaign: CampaignInput, result: MonteCarloResult) -> dict[str, Any]:
    network, confidence = campaign.network, campaign.confidence
    images, points = (all_elements(result, kind, confidence) for kind in ("eop", "points"))
    splines, locations = all_splines(result, confidence), all_locations(result, confidence)
    flat = [e for item in images for e in item], [e for item in points for e in item]
    across = result.across_normalized
    of_curve = network.curve_observations.curve[given_locations(network)]
    return {
        "alpha": result.alpha,
        "sigmas_scaled_by_sigma0": result.scaled,
        "acceptance": _figure(result.acceptance) if len(result.accepted) else None,
        "mean_square": _figure(result.mean_square),
        "sigma0_rms": float(np.sqrt(np.nanmean(result.sigma0**2))) if len(result.accepted) else None,
        "kinds": {
            "eop": _kind(kind_statistics(flat[0], result, confidence)),
            "points": _kind(kind_statistics(flat[1], result, confidence)),
            "splines": _kind(kind_statistics(splines, result, confidence)),
            "locations": _kind(kind_statistics(locations, result, confidence)),
        },
        "images": [
            {
                "id": id,
                **{
                    key: _element(each, _DEGREES if j < 3 else 1.0)
                    for j, (key, each) in enumerate(zip(_EOP, item, strict=True))
                },
            }
            for id, item in zip(network.images.ids, images, strict=True)
        ],
        "points": [
            {"id": id, **{key: _element(each) for key, each in zip("xyz", item, strict=True)}}
            for id, item in zip(network.points.ids, points, strict=True)
        ],
        "splines": [
            {
                "id": curve.id,
                "role": curve.role,
                "across": _spline(each),
                "locations": _locations(
                    [locations[q] for q in np.flatnonzero(of_curve == k)], result, confidence
                ),
            }
            for k, (curve, each) in enumerate(zip(network.curves, splines, strict=True))
        ],
        "histogram": {
            "edges": HISTOGRAM_EDGES,
            "eop": histogram(result.normalized),
            "points": histogram(result.point_normalized),
            "splines": histogram(across),
            "locations": histogram(result.locations_normalized),
        },
    }


def _figure(figure: Figure) -> dict[str, Any]:
    return {"value": figure.value, "lower": figure.lower, "upper": figure.upper, "inside": figure.inside}


def _element(statistics: ElementStatistics | None, unit: float = 1.0) -> dict[str, Any] | None:
    if statistics is None:
        return None
    return {
        "runs": statistics.runs,
        "bias": unit * statistics.bias,
        "bias_sigma": unit * statistics.bias_sigma,
        "empirical": unit * statistics.empirical,
        "predicted": unit * statistics.predicted,
        "ratio": _figure(statistics.ratio),
        "coverage": _figure(statistics.coverage),
    }


def _spline(statistics: SplineStatistics | None) -> dict[str, Any] | None:
    if statistics is None:
        return None
    return {
        "runs": statistics.runs,
        "bias_left": statistics.bias[0],
        "bias_left_sigma": statistics.bias_sigma[0],
        "bias_up": statistics.bias[1],
        "bias_up_sigma": statistics.bias_sigma[1],
        "largest_bias_in_sigma": statistics.largest_bias,
        "largest_bias_place": statistics.largest_bias_place,
        "largest_bias_limit": statistics.largest_bias_limit,
        "empirical": statistics.empirical,
        "ratio": _figure(statistics.ratio),
        "coverage": _figure(statistics.coverage),
    }


def _locations(
    items: Sequence[ElementStatistics | None], result: MonteCarloResult, confidence: float
) -> dict[str, Any] | None:
    """All locations on one curve; None where its parameter is not determined."""
    kind = kind_statistics(items, result, confidence)
    if kind is None:
        return None
    bias, limit = largest_bias(items)
    return {**(_kind(kind) or {}), "largest_bias_in_sigma": bias, "largest_bias_limit": limit}


def _kind(statistics: KindStatistics | None) -> dict[str, Any] | None:
    if statistics is None:
        return None
    lower, upper = statistics.ratio_limits
    return {
        "elements": statistics.elements,
        "coverage": _figure(statistics.coverage),
        "smallest_ratio": _figure(Figure(statistics.smallest_ratio, lower, upper)),
        "largest_ratio": _figure(Figure(statistics.largest_ratio, lower, upper)),
    }


def _reasons(failures: tuple[tuple[Failure, int], ...]) -> list[dict[str, Any]]:
    return [
        {"code": f.code, "title": ERROR_CODES.get(f.code, ""), "count": count, "example": f.message}
        for f, count in failures
    ]


def _study(statistics: StudyStatistics, noise: Noise) -> dict[str, Any]:
    start = noise.with_starts(statistics.factor)
    angle = start.start_angle_rad
    return {
        "factor": statistics.factor,
        "position_m": start.start_position_m,
        "angle_deg": None if angle is None else _DEGREES * angle,
        "knots_m": start.start_knots_m,
        "runs": statistics.runs,
        "same": {
            "value": statistics.same.value,
            "lower": statistics.same.lower,
            "upper": statistics.same.upper,
        },
        "other_minimum": statistics.other_minimum,
        "failed": statistics.failed,
        "iterations_median": statistics.iterations,
        "reasons": _reasons(statistics.failures),
    }
