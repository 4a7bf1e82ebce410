"""Whole residuals of all observations written a second time, for complex arguments.

Nothing here is the package's: rotation by its series, Brown's polynomial, projection, scipy's cubic splines and the
inverse trigonometric functions that define the angles.  The derivative of f at x is Im f(x + ih) / h, h = 1e-25.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

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
    """The curve of `values` at u; closed ones wrap, open ones extend their end segments.

    Parameters
    ----------
    parameters : ends of the segments
    """
    family, closed = curve.family, curve.closed
    if family == "straight_line":
        return np.asarray((1.0 - u) * values[0] + u * values[1])
    if family in ("fourier", "conic", "circle"):
        turns = range(1, (len(values) + 1) // 2)
        waves = (np.cos(k * u) * values[2 * k - 1] + np.sin(k * u) * values[2 * k] for k in turns)
        return np.asarray(values[0] + sum(waves))
    if closed:
        period = parameters[-1] - parameters[0]
        u = u - period * np.floor((np.real(u) - parameters[0]) / period)
    segment = int(np.clip(np.searchsorted(parameters, np.real(u), side="right") - 1, 0, len(parameters) - 2))
    t = u - parameters[segment]
    if family.startswith("polynomial") or family == "free_cubic":
        degree = 3 if family == "free_cubic" else int(family[-1])
        own = values[segment * (degree + 1) :][: degree + 1]
        t = t / (parameters[segment + 1] - parameters[segment])
        return np.asarray(sum(value * t**k for k, value in enumerate(own)))
    if family.startswith("bspline"):
        return bspline_point(parameters, values, int(family[-1]), closed, segment, u)
    tension = 0.0 if family == "natural_cubic" else curve.tension
    pieces = spline_pieces(
        family, closed, tension, tuple(parameters.tolist()), tuple(values.ravel().tolist())
    )
    return np.asarray(sum(pieces[3 - k, segment] * t**k for k in range(4)))


@lru_cache(maxsize=64)
def spline_pieces(
    family: str, closed: bool, tension: float, parameters: tuple[float, ...], values: tuple[complex, ...]
) -> Array:
    """Coefficients of scipy's cubic spline, (4, segments, 3), kept for the next points of the same curve."""
    u, points = np.array(parameters), np.array(values).reshape(-1, 3)
    if closed:
        points = np.vstack([points, points[:1]])
    if family == "natural_cubic":
        return np.asarray(CubicSpline(u, points, bc_type="periodic" if closed else "natural").c)
    return np.asarray(CubicHermiteSpline(u, points, (1.0 - tension) * neighbour_slopes(u, points, closed)).c)


def neighbour_slopes(parameters: FloatArray, values: Array, closed: bool) -> Array:
    """(P_{i+1} - P_{i-1}) / (u_{i+1} - u_{i-1}), one-sided at the ends of an open curve."""
    u, period = list(parameters), parameters[-1] - parameters[0]
    if closed:
        u, values = [u[-2] - period, *u, u[1] + period], np.vstack([values[-2], values, values[1]])
    else:
        u, values = [u[0], *u, u[-1]], np.vstack([values[0], values, values[-1]])
    return np.array([(values[i + 1] - values[i - 1]) / (u[i + 1] - u[i - 1]) for i in range(1, len(u) - 1)])


def bspline_point(
    parameters: FloatArray, values: Array, degree: int, closed: bool, segment: int, u: complex
) -> Array:
    """de Boor's algorithm on the control points of one segment."""
    period = parameters[-1] - parameters[0]
    if closed:
        n = len(parameters) - 1
        knots = [parameters[i % n] + period * (i // n) for i in range(-degree, n + degree + 1)]
        points = [values[(segment + j) % n] for j in range(degree + 1)]
    else:
        knots = [parameters[0]] * degree + list(parameters) + [parameters[-1]] * degree
        points = [values[segment + j] for j in range(degree + 1)]
    at = segment + degree
    for r in range(1, degree + 1):
        for j in range(degree, r - 1, -1):
            left, right = knots[at - degree + j], knots[at + 1 + j - r]
            share = (u - left) / (right - left)
            points[j] = (1.0 - share) * points[j - 1] + share * points[j]
    return np.asarray(points[degree])


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
