"""Elements of a conic X = C + A cos u + B sin u: centre, semi-axes, directions, normal, eccentricity, dispersion.

The singular values of M = [A B] (3 x 2) = U diag(a, b) V' are the semi-axes, the columns of U the directions of the
axes, n = U_1 x U_2 the normal; with dM the change of A and B,

    da = U_1' dM V_1,   db = U_2' dM V_2,   dn . U_k = - n' dM V_k / (a or b),
    e = sqrt(1 - b^2 / a^2),   de = (b^2 / a^3 da - b / a^2 db) / e

which hold for any conjugate pair A, B.  The phase of u (the gauge) changes none of them.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.result import ConicElements

ROUND = 1e-6  # eccentricity below which a conic is a circle
PARABOLA = 1e-9  # distance of the eccentricity of a parabola from 1


def conic_elements(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Semi-axes (2,), directions of the axes (2, 3), unit normal (3,) and eccentricity of C, A, B (3, 3).

    The normal is directed upwards (Z > 0; Y or X where Z is 0).
    """
    u, axes, _ = np.linalg.svd(values[1:].T, full_matrices=False)
    normal = np.cross(u[:, 0], u[:, 1])
    last = np.flatnonzero(np.abs(normal) > 1e-12)[-1]
    normal = normal if normal[last] > 0.0 else -normal
    return axes, u.T, normal, float(np.sqrt(max(1.0 - (axes[1] / axes[0]) ** 2, 0.0)))


def conic_form(eccentricity: float) -> str:
    """Name of a conic by its eccentricity (Lee, table 4.1).

    A bounded curve C + A cos u + B sin u is always a circle or an ellipse.
    """
    if eccentricity < ROUND:
        return "circle"
    if abs(eccentricity - 1.0) < PARABOLA:
        return "parabola"
    return "ellipse" if eccentricity < 1.0 else "hyperbola"


def conic_jacobian(values: FloatArray) -> FloatArray:
    """Derivatives of (a, b, e, n . U_1, n . U_2) over (C, A, B), (5, 9).

    The last two are the small angles by which the normal turns towards the axes, rad.  Those of the eccentricity are
    NaN for a circle, where it has none.
    """
    u, axes, vt = np.linalg.svd(values[1:].T, full_matrices=False)
    normal = conic_elements(values)[2]
    out = np.zeros((5, 9))
    for k in range(2):
        out[k, 3:] = np.outer(vt[k], u[:, k]).ravel()  # dM V_k = V_k1 dA + V_k2 dB
        out[3 + k, 3:] = -np.outer(vt[k], normal).ravel() / axes[k]
    a, b = axes
    eccentricity = np.sqrt(max(1.0 - (b / a) ** 2, 0.0))
    if eccentricity < ROUND:
        out[2] = np.nan
    else:
        out[2] = (b**2 / a**3 * out[0] - b / a**2 * out[1]) / eccentricity
    return out


def adjusted_conic(cofactors: Cofactors, k: int, own: FloatArray, scale: float) -> ConicElements:
    """Elements of one adjusted conic with their dispersion by the chain rule; centre in the local frame."""
    curves = cofactors.assembler.prepared.curves
    start = int(curves.coefficient_start[k])
    dispersion = cofactors.coefficient_windows(start + np.arange(3)[None])[0] * scale
    axes, directions, normal, eccentricity = conic_elements(own)
    jacobian = conic_jacobian(own)
    is_circle = len(curves.bases[k].shape_forms) > 0
    jacobian[2] = 0.0 if is_circle else jacobian[2]
    spread = jacobian @ dispersion @ jacobian.T
    sigma = np.sqrt(np.maximum(np.diag(spread), 0.0))
    turning = np.linalg.eigvalsh(spread[3:, 3:])[-1]
    return ConicElements(
        centre=own[0],
        semi_axes=axes,
        axes=directions,
        normal=normal,
        eccentricity=0.0 if is_circle else eccentricity,
        form="circle" if is_circle else conic_form(eccentricity),
        centre_sigma=np.sqrt(np.maximum(np.diag(dispersion)[:3], 0.0)),
        semi_axes_sigma=sigma[:2],
        eccentricity_sigma=float(sigma[2]),
        normal_sigma_rad=float(np.sqrt(max(turning, 0.0))),
    )
