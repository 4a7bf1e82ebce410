"""Tests and reliability of single observations in few numbers: the ``tests`` part of result.json.

Minimal detectable biases in the unit of the kind (mm in the photo, degrees, metres); effects in metres and degrees.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from splinebba_cli.core.evidence import Influence
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.residual_summary import taking_part

WEAK = 0.1  # redundancy number below which an observation is weakly controlled
UNCONTROLLED = 1e-3
DEGREES = 180.0 / np.pi


@dataclass(frozen=True)
class _Kind:
    """Figures of all tested equations of one kind."""

    name: str
    unit: Literal["mm", "deg", "m"]
    redundancy: FloatArray  # (n,)
    bias: FloatArray  # (n,) minimal detectable, in `unit`
    standardized: FloatArray  # (n,) w


def local_tests_part(result: AdjustmentResult) -> dict[str, Any] | None:
    """Significance and power, reliability by kind, most influential observations; None where nothing is tested."""
    tests = result.evidence.tests
    if tests is None:
        return None
    result = taking_part(result)
    ratio = result.statistics.sigma0_prior / result.statistics.sigma0 if tests.statistic == "tau" else 1.0
    return {
        "statistic": tests.statistic,
        "alpha": tests.alpha,
        "multiplicity": tests.multiplicity,
        "alpha_single": tests.alpha_single,
        "power": tests.power,
        "tests": tests.tests,
        "critical": tests.critical,
        "noncentrality": tests.noncentrality,
        "beyond": tests.beyond,
        "kinds": [_summary(kind, ratio) for kind in _kinds(result) if len(kind.redundancy)],
        "influences": [_influence(influence) for influence in result.evidence.influences],
    }


def _summary(kind: _Kind, ratio: float) -> dict[str, Any]:
    """Redundancy numbers, minimal detectable biases and the largest statistic of one kind."""
    r, bias = kind.redundancy, kind.bias[np.isfinite(kind.bias)]
    size = np.abs(kind.standardized[np.isfinite(kind.standardized)]) * ratio
    return {
        "kind": kind.name,
        "n": len(r),
        "redundancy": {"min": float(r.min()), "mean": float(r.mean()), "max": float(r.max())},
        "weak": int((r < WEAK).sum()),
        "uncontrolled": int((r < UNCONTROLLED).sum()),
        "unit": kind.unit,
        "minimal_detectable_bias": {
            "median": float(np.median(bias)) if len(bias) else None,
            "max": float(bias.max()) if len(bias) else None,
        },
        "largest": float(size.max()) if len(size) else None,
    }


def _kinds(result: AdjustmentResult) -> list[_Kind]:
    points, curves = result.point_residuals, result.curve_residuals
    arcs, tangents, distances = result.arc_residuals, result.tangent_residuals, result.distance_residuals
    along: BoolArray = ~np.isnan(curves.reliability.minimal_detectable_bias[:, 1])
    across_of = (
        curves.redundancy[:, 0],
        curves.reliability.minimal_detectable_bias[:, 0],
        curves.standardized[:, 0],
    )
    along_of = (
        curves.redundancy[along, 1], curves.reliability.minimal_detectable_bias[along, 1], curves.standardized[along, 1]
    )  # fmt: skip
    return [
        _Kind(
            "points, per coordinate", "mm", points.redundancy.ravel(),
            points.reliability.minimal_detectable_bias.ravel(), points.standardized.ravel(),
        ),
        _Kind("splines, across", "mm", *across_of),
        _Kind("splines, along", "mm", *along_of),
        _Kind("arc lengths", "mm", arcs.redundancy, arcs.reliability.minimal_detectable_bias, arcs.standardized),
        _Kind(
            "tangents", "deg", tangents.redundancy, DEGREES * tangents.reliability.minimal_detectable_bias,
            tangents.standardized,
        ),
        _Kind(
            "distances", "m", distances.redundancy, distances.reliability.minimal_detectable_bias,
            distances.standardized,
        ),
        *_prior_kinds(result),
    ]  # fmt: skip


def _prior_kinds(result: AdjustmentResult) -> list[_Kind]:
    """Control points, control splines and prior orientations; positions and angles apart."""
    priors = result.prior_residuals
    found = []
    for kind, angular, rows in priors.groups():
        tested = rows[~np.isnan(priors.minimal_detectable_bias[rows])]
        if len(tested):
            found.append(
                _Kind(
                    f"{kind}, angles" if angular else kind, "deg" if angular else "m", priors.redundancy[tested],
                    (DEGREES if angular else 1.0) * priors.minimal_detectable_bias[tested],
                    priors.standardized[tested],
                )
            )  # fmt: skip
    return found


def _influence(influence: Influence) -> dict[str, Any]:
    angular = influence.unit == "rad"
    return {
        "kind": influence.kind,
        "observation": influence.name,
        "redundancy": influence.redundancy,
        "unit": "deg" if angular else influence.unit,
        "minimal_detectable_bias": influence.minimal_detectable_bias * (DEGREES if angular else 1.0),
        "bias_to_noise": influence.bias_to_noise,
        "orientation": {"sigmas": influence.orientation, "image": influence.orientation_image},
        "position": {"m": influence.position_m, "image": influence.position_image},
        "angle": {"deg": DEGREES * influence.angle_rad, "image": influence.angle_image},
        "object": {"m": influence.object_m, "feature": influence.object_name},
    }
