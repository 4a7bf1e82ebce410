"""Whole residuals of all observations written a second time, for complex arguments.

Nothing here is the package's: rotation by its series, Brown's polynomial, projection, scipy's cubic splines and the
inverse trigonometric functions that define the angles.  The derivative of f at x is Im f(x + ih) / h, h = 1e-25.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from splinebba_cli.core.network import Camera, Curve, FloatArray

Array = np.ndarray[Any, Any]
STEP = 1e-25


def jacobian(function: Callable[[Array], Array], x: FloatArray) -> FloatArray:
    """Derivatives of a vector function (n,) over x (p,), (n, p)."""
    columns = []
    for k in range(len(x)):
        moved = x.astype(complex)
        moved[k] += 1j * STEP
        columns.append(np.imag(function(moved)) / STEP)
    return np.stack(columns, axis=-1)


def turned(rotation: FloatArray, theta: Array) -> Array:
    """R exp([theta]x) for a small theta."""
    x, y, z = theta
    k = np.array([[0.0 * x, -z, y], [z, 0.0 * x, -x], [-y, x, 0.0 * x]])
    return np.asarray(rotation @ (np.eye(3) + k + k @ k / 2.0 + k @ k @ k / 6.0))


def photo_xy(camera: Camera, rotation: Array, position: Array, xyz: Array) -> Array:
    """Collinearity equations, origin at the principal point."""
    u, v, w = rotation.T @ (xyz - position)
    return np.array([-camera.principal_distance_mm * u / w, -camera.principal_distance_mm * v / w])


def corrected(camera: Camera, measured: Array) -> Array:
    """measured + Brown(measured) + affinity, origin at the principal point."""
    x, y = measured - camera.principal_point_mm
    square = x**2 + y**2
    k1, k2, k3 = camera.radial
    p1, p2 = camera.decentring
    b1, b2 = camera.affinity
    radial = k1 * square + k2 * square**2 + k3 * square**3
    return np.array(
        [
            x + x * radial + p1 * (square + 2 * x**2) + 2 * p2 * x * y + b1 * x + b2 * y,
            y + y * radial + 2 * p1 * x * y + p2 * (square + 2 * y**2),
        ]
    )


def whitened(camera: Camera, sigma: FloatArray, measured: FloatArray, computed: Array) -> Array:
    """Residual of corrected coordinates, carried back to the measured ones and divided by their sigma."""
    back = np.linalg.inv(jacobian(lambda xy: corrected(camera, xy), measured))
    return np.asarray((back @ (computed - corrected(camera, measured))) / sigma)


def curve_point(curve: Curve, parameters: FloatArray, values: Array, u: complex) -> Array:
    """The curve through (or with) `values` at u; open splines extend their end segments.

    Parameters
    ----------
    parameters : knot parameters of a spline, not used for the other families
    """
    if curve.family == "straight_line":
        return np.asarray((1.0 - u) * values[0] + u * values[1])
    if curve.family != "natural_cubic":
        return np.asarray(sum(value * u**k for k, value in enumerate(values)))
    if curve.closed:
        values = np.vstack([values, values[:1]])
    spline = CubicSpline(parameters, values, bc_type="periodic" if curve.closed else "natural")
    segment = int(np.clip(np.searchsorted(parameters, np.real(u), side="right") - 1, 0, len(parameters) - 2))
    t = u - parameters[segment]
    return np.asarray(sum(spline.c[3 - k, segment] * t**k for k in range(4)))


def angles(rotation: Array, sequence: str) -> Array:
    """omega, phi, kappa; arc tangents without the quadrant, which a derivative does not see."""
    if sequence == "omega-phi-kappa":
        omega = np.arctan(-rotation[1, 2] / rotation[2, 2])
        phi = np.arcsin(rotation[0, 2])
        kappa = np.arctan(-rotation[0, 1] / rotation[0, 0])
    else:
        omega = np.arcsin(-rotation[1, 2])
        phi = np.arctan(rotation[0, 2] / rotation[2, 2])
        kappa = np.arctan(rotation[1, 0] / rotation[1, 1])
    return np.array([omega, phi, kappa])
