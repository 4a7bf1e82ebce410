"""Residuals, redundancy numbers and standardised residuals of all observations, in the user's measured frames."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE
from splinebba_cli.core.observations.orientation_priors import weighting_sigma
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.result import PriorResidual, ResidualTable, ScalarResiduals
from splinebba_cli.core.state import Prepared

TINY = 1e-9
EOP_NAMES = ("omega", "phi", "kappa", "x", "y", "z")
AXES = ("x", "y", "z", "along the curve")


def _standardized(whitened: FloatArray, redundancy: FloatArray) -> FloatArray:
    return np.where(redundancy > TINY, whitened / np.sqrt(np.maximum(redundancy, TINY)), np.nan)


def point_table(prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers) -> ResidualTable:
    """Residuals of the image points of points."""
    whitened = solved.solution.linearization.points.residual
    observed = prepared.network.point_observations
    missing = np.full(len(observed), np.nan)
    return ResidualTable(
        residual=whitened * observed.sigma,
        across=missing,
        redundancy=numbers.image_points,
        standardized=_standardized(whitened, numbers.image_points),
        location=missing,
        location_sigma=missing,
        normal=np.full((len(observed), 2), np.nan),
    )


def curve_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, location_sigma: FloatArray
) -> ResidualTable:
    """Residuals of the image points of curves: across, and along where the location is held or linked to others."""
    rows, linked = solved.solution.linearization.curve, np.flatnonzero(prepared.chains.linked)
    observed = prepared.network.curve_observations
    count = len(observed)
    held = rows.point[count:]
    across = rows.residual[:count]
    unit = np.stack([rows.normal[:, 1], -rows.normal[:, 0]], axis=1)
    along = np.zeros(count)
    along[held] = rows.residual[count:]
    along[linked] = solved.solution.linearization.linked.along[linked]
    redundancy = np.zeros((count, 2))
    redundancy[:, 0] = numbers.curve_rows[:count]
    redundancy[held, 1] = numbers.curve_rows[count:]
    redundancy[linked, 1] = numbers.linked_along[linked]
    tested = np.concatenate([held, linked])
    standardized = np.full((count, 2), np.nan)
    standardized[:, 0] = _standardized(across, redundancy[:, 0])
    standardized[tested, 1] = _standardized(along[tested], redundancy[tested, 1])
    across_vector = rows.normal * across[:, None] * observed.sigma
    residual = across_vector + unit * along[:, None] * observed.sigma
    # a normal in measured photo axes: whitening by equal sigma does not turn it
    normal = rows.normal / observed.sigma
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return ResidualTable(
        residual=residual,
        across=np.sign(across) * np.linalg.norm(across_vector, axis=1),
        redundancy=redundancy,
        standardized=standardized,
        location=solved.solution.state.location,
        location_sigma=location_sigma,
        normal=normal,
    )


def arc_table(prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers) -> ScalarResiduals:
    """Residuals of the arc lengths, mm."""
    whitened = solved.solution.linearization.linked.arc_residual
    return _scalar_table(whitened, prepared.network.arc_lengths.sigma, numbers.arc_lengths)


def tangent_table(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> ScalarResiduals:
    """Residuals of the tangents, rad."""
    whitened = solved.solution.linearization.linked.tangent_residual
    return _scalar_table(whitened, prepared.network.tangents.sigma, numbers.tangents)


def _scalar_table(whitened: FloatArray, sigma: FloatArray, redundancy: FloatArray) -> ScalarResiduals:
    return ScalarResiduals(whitened * sigma, sigma, redundancy, _standardized(whitened, redundancy))


def prior_residuals(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> tuple[PriorResidual, ...]:
    """Residuals of control coordinates, control values of curves, orientation priors and gauge conditions."""
    return (
        *_point_priors(prepared, solved, numbers),
        *_value_and_gauge(prepared, solved, numbers),
        *_orientation_priors(prepared, solved, numbers),
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
