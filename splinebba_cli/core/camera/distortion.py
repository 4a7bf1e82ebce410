"""Lens distortion and affinity, as a correction of measured photo coordinates (backward model).

With (x, y) = measured - principal point and r^2 = x^2 + y^2

    dx = x (K1 r^2 + K2 r^4 + K3 r^6) + P1 (r^2 + 2 x^2) + 2 P2 x y + b1 x + b2 y
    dy = y (K1 r^2 + K2 r^4 + K3 r^6) + 2 P1 x y + P2 (r^2 + 2 y^2)
    corrected = (x + dx, y + dy)

so that corrected = measured + Brown(measured) (Brown 1971; the signs are DBAT's).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import Camera, FloatArray


def corrected_photo_xy(camera: Camera, photo_xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Photo coordinates freed of principal point, distortion and affinity.

    Parameters
    ----------
    photo_xy : (n, 2) float, millimetres, as measured

    Returns
    -------
    corrected : (n, 2) float, millimetres, origin at the principal point
    jacobian : (n, 2, 2) float, d corrected / d measured
    """
    x = photo_xy[:, 0] - camera.principal_point_mm[0]
    y = photo_xy[:, 1] - camera.principal_point_mm[1]
    k1, k2, k3 = camera.radial
    p1, p2 = camera.decentring
    b1, b2 = camera.affinity
    square = x * x + y * y
    radial = square * (k1 + square * (k2 + square * k3))
    slope = k1 + square * (2.0 * k2 + square * 3.0 * k3)  # d radial / d r^2
    corrected = np.empty_like(photo_xy)
    corrected[:, 0] = x + x * radial + p1 * (square + 2 * x * x) + 2 * p2 * x * y + b1 * x + b2 * y
    corrected[:, 1] = y + y * radial + 2 * p1 * x * y + p2 * (square + 2 * y * y)
    jacobian = np.empty((len(x), 2, 2), dtype=photo_xy.dtype)
    jacobian[:, 0, 0] = 1 + radial + 2 * x * x * slope + 6 * p1 * x + 2 * p2 * y + b1
    jacobian[:, 0, 1] = 2 * x * y * slope + 2 * p1 * y + 2 * p2 * x + b2
    jacobian[:, 1, 0] = 2 * x * y * slope + 2 * p1 * y + 2 * p2 * x
    jacobian[:, 1, 1] = 1 + radial + 2 * y * y * slope + 2 * p1 * x + 6 * p2 * y
    return corrected, jacobian


def measured_photo_xy(camera: Camera, corrected: FloatArray, iterations: int = 50) -> FloatArray:
    """The measured coordinates that :func:`corrected_photo_xy` turns into `corrected` (Newton's method), (n, 2) mm."""
    measured = corrected + camera.principal_point_mm
    for _ in range(iterations):
        value, jacobian = corrected_photo_xy(camera, measured)
        step = np.linalg.solve(jacobian, (corrected - value)[..., None])[..., 0]
        measured = measured + step
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return np.asarray(measured)
