"""Residuals of control coordinates, control values of curves, prior orientations and conditions, one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE
from splinebba_cli.core.observations.orientation_priors import weighting_sigma
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.reliability import reliability, standardized_residuals
from splinebba_cli.core.result import PriorResidual
from splinebba_cli.core.state import Prepared

EOP_NAMES = ("omega", "phi", "kappa", "x", "y", "z")
AXES = ("x", "y", "z", "along the curve")
CONDITIONS = ("gauge", "shape", "datum")


def prior_residuals(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> tuple[PriorResidual, ...]:
    """All of them; `delta0` is the noncentrality of their tests.  Conditions are not tested."""
    priors = (
        *_point_priors(prepared, solved, numbers),
        *_value_and_gauge(prepared, solved, numbers),
        *_orientation_priors(prepared, solved, numbers),
    )
    tested = [prior for prior in priors if prior.kind not in CONDITIONS]
    r = np.array([prior.redundancy for prior in tested])
    sigma = np.array([prior.sigma for prior in tested])
    residual = np.array([prior.residual for prior in tested])
    found = reliability(sigma, r, 1.0 - r, delta0)
    w = standardized_residuals(residual / sigma, r) if len(tested) else r
    figures = iter(zip(tested, w, found.minimal_detectable_bias, found.bias_to_noise, strict=True))
    return tuple(prior if prior.kind in CONDITIONS else _with_figures(*next(figures)) for prior in priors)


def _with_figures(prior: PriorResidual, w: float, bias: float, ratio: float) -> PriorResidual:
    return replace(
        prior, standardized=float(w), minimal_detectable_bias=float(bias), bias_to_noise=float(ratio)
    )


def _point_priors(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> list[PriorResidual]:
    points, state = prepared.network.points, solved.solution.state
    difference = state.xyz - points.xyz
    return [
        PriorResidual(
            "control point",
            points.ids[n],
            AXES[d],
            float(difference[n, d]),
            float(points.sigma[n, d]),
            float(numbers.point_priors[n, d]),
        )
        for n, d in zip(*np.nonzero(solved.assembler.point_inverse_sigma > 0.0), strict=True)
    ]


def _value_and_gauge(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> list[PriorResidual]:
    rows = solved.assembler.coefficient_rows
    whitened = solved.solution.linearization.coefficient_residual
    found = []
    for k in range(len(rows)):
        component = int(rows.component[k])
        found.append(
            PriorResidual(
                {GAUGE: "gauge", SHAPE: "shape"}.get(component, "control spline"),
                prepared.network.curves[rows.curve[k]].id,
                f"condition {rows.row[k]}" if component == SHAPE else f"knot {rows.row[k]} {AXES[component]}",
                float(whitened[k] * rows.sigma[k]),
                float(rows.sigma[k]),
                float(numbers.coefficient_rows[k]),
            )
        )
    return found


def _orientation_priors(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> list[PriorResidual]:
    priors, images = solved.solution.linearization.orientation_priors, prepared.network.images
    given = weighting_sigma(images)
    found = []
    for q, c in zip(*np.nonzero(priors.active), strict=True):
        sigma = float(given[priors.image[q], c])
        found.append(
            PriorResidual(
                "eop prior",
                images.ids[priors.image[q]],
                EOP_NAMES[c],
                float(priors.residual[q, c] * sigma),
                sigma,
                float(numbers.orientation_priors[q, c]),
            )
        )
    return found
