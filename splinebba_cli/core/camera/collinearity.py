"""Collinearity equations, with derivatives (Lee 3.12-3.18).

    p = (u v w)' = R' (X - X0),   x = -c u/w,   y = -c v/w

relative to the principal point, free of distortion.  With A = d(x, y)/dX (2 x 3) and R <- R exp([theta]x):

    d(x, y)/dX0 = -A,    d(x, y)/dtheta = G [p]x,    A = G R',    G = -1/w [[c, 0, x], [0, c, y]]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray


@dataclass(frozen=True)
class CollinearityJacobian:
    """Derivatives of photo coordinates."""

    orientation: FloatArray  # (n, 2, 6): theta (photo frame, rad), X0 (m)
    object_xyz: FloatArray  # (n, 2, 3)


def photo_frame_xyz(rotation: FloatArray, position: FloatArray, object_xyz: FloatArray) -> FloatArray:
    """Points in the photo frame, p = R' (X - X0), (n, 3) metres; rows in front of the camera have w < 0."""
    return np.asarray(np.einsum("nji,nj->ni", rotation, object_xyz - position))


def project(
    principal_distance_mm: FloatArray, rotation: FloatArray, position: FloatArray, object_xyz: FloatArray
) -> FloatArray:
    """Photo coordinates of object points relative to the principal point.

    Parameters
    ----------
    principal_distance_mm : (n,) float
    rotation : (n, 3, 3) float, object from photo
    position : (n, 3) float, metres
    object_xyz : (n, 3) float, metres

    Returns
    -------
    (n, 2) float, millimetres; NaN where a point lies in or behind the photo plane (w >= 0)
    """
    p = photo_frame_xyz(rotation, position, object_xyz)
    w = np.where(p[:, 2].real < 0.0, p[:, 2], np.nan)
    return np.asarray(-principal_distance_mm[:, None] * p[:, :2] / w[:, None])


def project_with_jacobian(
    principal_distance_mm: FloatArray, rotation: FloatArray, position: FloatArray, object_xyz: FloatArray
) -> tuple[FloatArray, CollinearityJacobian]:
    """Photo coordinates as :func:`project`, and their derivatives."""
    p = photo_frame_xyz(rotation, position, object_xyz)
    w = np.where(p[:, 2] < 0.0, p[:, 2], np.nan)
    c = principal_distance_mm
    xy = -c[:, None] * p[:, :2] / w[:, None]
    factor = -1.0 / w
    g0, gx, gy = factor * c, factor * xy[:, 0], factor * xy[:, 1]
    point = np.empty((len(p), 2, 3))
    point[:, 0] = g0[:, None] * rotation[:, :, 0] + gx[:, None] * rotation[:, :, 2]
    point[:, 1] = g0[:, None] * rotation[:, :, 1] + gy[:, None] * rotation[:, :, 2]
    orientation = np.empty((len(p), 2, 6))
    u, v, depth = p[:, 0], p[:, 1], p[:, 2]
    orientation[:, 0, 0] = -gx * v
    orientation[:, 0, 1] = gx * u - g0 * depth
    orientation[:, 0, 2] = g0 * v
    orientation[:, 1, 0] = g0 * depth - gy * v
    orientation[:, 1, 1] = gy * u
    orientation[:, 1, 2] = -g0 * u
    orientation[:, :, 3:] = -point
    return xy, CollinearityJacobian(orientation, point)
