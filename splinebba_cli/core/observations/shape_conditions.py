"""Exact shape conditions of curves (a circle's equal and normal radius vectors), as equations of very large weight.

    1/2 sum_jl K_jl P_j . P_l / (R sigma) = v,   R a length of the curve, sigma = 1e-6 R

Every state of the iterations fulfils them (:func:`splinebba_cli.core.state.on_shape`), so that their residuals are 0
and their rows keep the steps, and the dispersion, tangential to what they allow.  They are conditions, but fill no
rank defect.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.shape_forms import form_jacobian
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.coefficient_rows import (
    HELD_FRACTION,
    SHAPE,
    CoefficientRows,
    concatenate_rows,
    knot_distance,
    value_rows,
)
from splinebba_cli.core.state import Prepared


def shape_rows(prepared: Prepared, removed: FloatArray) -> CoefficientRows:
    """Shape conditions of all curves whose shape is not held.

    Parameters
    ----------
    removed : (C, 3) mask, 0 where a coefficient is fixed and removed
    """
    support = prepared.curves.support
    parts = []
    for number in prepared.curves.shaped:
        curve, basis = prepared.network.curves[number], prepared.curves.bases[number]
        start, forms = int(prepared.curves.coefficient_start[number]), basis.shape_forms
        count = basis.coefficient_count
        reference = curve.values if curve.reference is None else curve.reference
        jacobian = form_jacobian(forms, basis.coefficients_from_values(reference))
        live = np.flatnonzero((np.abs(jacobian) * removed[start : start + count]).sum(axis=(1, 2)) > 0.0)
        length = knot_distance(curve)
        sigma = HELD_FRACTION * length
        columns = np.full((len(live), support), start)
        columns[:, :count] = start + np.arange(count)
        curvature = np.zeros((len(live), support, support))
        curvature[:, :count, :count] = forms[live] / (length * sigma)
        parts.append(
            CoefficientRows(
                np.full(len(live), number),
                live,
                np.full(len(live), SHAPE),
                columns,
                np.zeros((len(live), support, 3)),
                np.zeros(len(live)),
                np.full(len(live), sigma),
                curvature,
            )
        )
    return concatenate_rows(parts, support)


def control_rows(prepared: Prepared, removed: FloatArray) -> CoefficientRows:
    """Everything that is known of curves beside measurements: given values and shape conditions."""
    return concatenate_rows(
        [value_rows(prepared, removed), shape_rows(prepared, removed)], prepared.curves.support
    )
