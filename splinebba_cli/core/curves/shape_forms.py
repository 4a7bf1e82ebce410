"""Exact shape conditions that are quadratic in the coefficients of a curve, such as those of a circle.

    f(P) = 1/2 sum_jl K_jl P_j . P_l = 0,    df/dP_j = sum_l K_jl P_l

Forms do not depend on the frame: K acts on the coefficients, the coordinates enter by scalar products.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray

STEPS = 20
EXACT = 1e-15  # of the size of the form


def form_values(forms: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Values of the forms (f, m, m) at coefficients (m, 3), (f,) square metres."""
    return np.asarray(0.5 * np.einsum("fjl,jd,ld->f", forms, coefficients, coefficients))


def form_jacobian(forms: FloatArray, coefficients: FloatArray) -> FloatArray:
    """Derivatives of the forms over the coefficients, (f, m, 3)."""
    return np.asarray(np.einsum("fjl,ld->fjd", forms, coefficients))


def retracted(forms: FloatArray, coefficients: FloatArray) -> FloatArray:
    """The nearest coefficients that fulfil the conditions, to first order in the distance, by Newton's method.

    Every step is the shortest one to the zeros of the linearised forms: p - J'(JJ')^-1 f.
    """
    found = coefficients.copy()
    for _ in range(STEPS):
        value, jacobian = form_values(forms, found), form_jacobian(forms, found)
        rows = jacobian.reshape(len(forms), -1)
        gram = rows @ rows.T
        if np.abs(value).max() <= EXACT * np.abs(gram).max() or not np.isfinite(value).all():
            break
        step = rows.T @ np.linalg.lstsq(gram, value, rcond=1e-12)[0]
        found = found - step.reshape(found.shape)
    return found
