"""Velocity of a projected curve in the image, with derivatives (Lee 3.20-3.25, 3.40-3.41; corrected).

With q = R' (X(u) - X0) = (U V W)', q1 = R' X'(u), q2 = R' X''(u) and the collinearity equations x = -c U/W,

    x' = -c (U1 W - U W1) / W^2,    y' = -c (V1 W - V W1) / W^2.

For any function f(x', y') with weights a = df/dx', b = df/dy', the vectors g = df/dq and g1 = df/dq1 give all
derivatives, since q and q1 turn alike under R <- R exp([theta]x):

    df/dtheta = g x q + g1 x q1,   df/dX0 = -R g,   df/dP_j = N_j R g + N_j' R g1,   df/du = g . q1 + g1 . q2
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray


def image_velocity(principal_distance_mm: FloatArray, q: FloatArray, q1: FloatArray) -> FloatArray:
    """Velocity (x', y') of projected curve points, (n, 2) mm per unit of u.

    Parameters
    ----------
    principal_distance_mm : (n,) float
    q, q1 : (n, 3) float
        Curve point relative to the perspective centre and d/du of the curve, both in photo axes, metres.
        Rows behind the camera (q[:, 2] >= 0) give NaN.
    """
    w = np.where(q[:, 2] < 0.0, q[:, 2], np.nan)
    slope = q1[:, :2] - q[:, :2] * (q1[:, 2] / w)[:, None]
    return np.asarray((-principal_distance_mm / w)[:, None] * slope)


def velocity_gradient(
    principal_distance_mm: FloatArray, q: FloatArray, q1: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Gradients over q and q1 of a function of the velocity.

    Parameters
    ----------
    weights : (n, 2) float, derivatives a, b of the function over x' and y'

    Returns
    -------
    g, g1 : (n, 3) float
    """
    w = q[:, 2]
    scale = principal_distance_mm / w
    g, g1 = np.empty_like(q), np.empty_like(q)
    g[:, :2] = weights * (scale * q1[:, 2] / w)[:, None]
    g1[:, :2] = -weights * scale[:, None]
    across = np.sum(weights * q[:, :2], axis=1)
    g[:, 2] = scale * (np.sum(weights * q1[:, :2], axis=1) - 2.0 * across * q1[:, 2] / w) / w
    g1[:, 2] = scale * across / w
    return g, g1


def orientation_gradient(
    rotation: FloatArray, q: FloatArray, q1: FloatArray, g: FloatArray, g1: FloatArray
) -> FloatArray:
    """Derivatives over theta (photo frame) and X0, (n, 6), of a function with gradients g, g1."""
    out = np.empty((len(q), 6))
    out[:, :3] = np.cross(g, q) + np.cross(g1, q1)
    out[:, 3:] = -np.matmul(rotation, g[:, :, None])[:, :, 0]
    return out
