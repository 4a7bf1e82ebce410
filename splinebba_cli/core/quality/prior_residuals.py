"""Residuals of control coordinates, control values of curves, prior orientations and conditions, one by one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE, SHAPE
from splinebba_cli.core.observations.orientation_priors import weighting_sigma
from splinebba_cli.core.prior_residuals import PriorResiduals, TextArray
from splinebba_cli.core.quality.redundancy import RedundancyNumbers
from splinebba_cli.core.quality.reliability import reliability, standardized_residuals
from splinebba_cli.core.state import Prepared

EOP_NAMES = ("omega", "phi", "kappa", "x", "y", "z")
AXES = ("x", "y", "z", "along the curve")
KINDS = ("control spline", "gauge", "shape")

Columns = tuple[TextArray, TextArray, TextArray, FloatArray, FloatArray, FloatArray]  # kind ... redundancy


def prior_residuals(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers, delta0: float
) -> PriorResiduals:
    """All of them; `delta0` is the noncentrality of their tests.  Conditions are not tested."""
    tested_values, is_condition = _values(prepared, solved, numbers)
    points = _point_priors(prepared, solved, numbers)
    orientations = _orientation_priors(prepared, solved, numbers)
    condition = np.concatenate(
        [np.zeros(len(points[3]), bool), is_condition, np.zeros(len(orientations[3]), bool)]
    )
    kind, subject, component, residual, sigma, redundancy = (
        np.concatenate(parts) for parts in zip(points, tested_values, orientations, strict=True)
    )
    found = reliability(sigma, redundancy, 1.0 - redundancy, delta0)
    w = standardized_residuals(residual / sigma, redundancy)
    figures = (
        np.where(condition, np.nan, each) for each in (w, found.minimal_detectable_bias, found.bias_to_noise)
    )
    return PriorResiduals(kind, subject, component, residual, sigma, redundancy, *figures)


def _point_priors(prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers) -> Columns:
    points, state = prepared.network.points, solved.solution.state
    n, d = np.nonzero(solved.assembler.point_inverse_sigma > 0.0)
    residual = state.xyz[n, d] - points.xyz[n, d]
    return (
        _texts(("control point",), np.zeros_like(n)), _texts(points.ids, n), _texts(AXES, d),
        residual, points.sigma[n, d], numbers.point_priors[n, d],
    )  # fmt: skip


def _values(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> tuple[Columns, BoolArray]:
    """Equations over coefficients, and which of them are conditions."""
    rows = solved.assembler.coefficient_rows
    kind = (rows.component >= GAUGE).astype(int) + (rows.component == SHAPE)
    ids = [curve.id for curve in prepared.network.curves]
    key, name = np.unique(rows.row * (SHAPE + 1) + rows.component, return_inverse=True)
    names = [
        f"condition {row}" if component == SHAPE else f"knot {row} {AXES[component]}"
        for row, component in (divmod(each, SHAPE + 1) for each in key.tolist())
    ]
    residual = solved.solution.linearization.coefficient_residual * rows.sigma
    columns = (
        _texts(KINDS, kind), _texts(ids, rows.curve), _texts(names, name),
        residual, rows.sigma, numbers.coefficient_rows,
    )  # fmt: skip
    return columns, rows.component >= GAUGE


def _orientation_priors(
    prepared: Prepared, solved: ConditionedSolution, numbers: RedundancyNumbers
) -> Columns:
    priors, images = solved.solution.linearization.orientation_priors, prepared.network.images
    q, c = np.nonzero(priors.active)
    sigma = weighting_sigma(images)[priors.image[q], c]
    return (
        _texts(("eop prior",), np.zeros_like(q)), _texts(images.ids, priors.image[q]), _texts(EOP_NAMES, c),
        priors.residual[q, c] * sigma, sigma, numbers.orientation_priors[q, c],
    )  # fmt: skip


def _texts(names: Sequence[str], numbers: IntArray) -> TextArray:
    """Names by number; equal ones share their text."""
    if not len(names):
        return np.zeros(0, dtype=object)
    return np.array(names, dtype=object)[numbers]
