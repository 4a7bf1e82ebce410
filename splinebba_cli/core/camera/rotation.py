"""Rotations R (object from photo) and their angles.

    omega-phi-kappa   R = R_x(omega) R_y(phi) R_z(kappa)      (Lee 3.13)
    phi-omega-kappa   R = R_y(phi) R_x(omega) R_z(kappa)

R turns photo axes into object axes: X - X0 = R p.  The solver updates R <- R exp([theta]x) with a small rotation
vector theta given in the photo frame; angles are for people only.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray, RotationSequence


def _elementary(angle: FloatArray, axis: int) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.zeros((*np.shape(angle), 3, 3), dtype=np.result_type(angle, np.float64))
    matrix[..., axis, axis] = 1.0
    matrix[..., i, i] = matrix[..., j, j] = c
    matrix[..., i, j] = -s
    matrix[..., j, i] = s
    return matrix


def rotation_object_from_photo(
    angles: FloatArray, sequence: RotationSequence = "omega-phi-kappa"
) -> FloatArray:
    """Rotation matrices of angles.

    Parameters
    ----------
    angles : (..., 3) float, radians, always in the order omega, phi, kappa

    Returns
    -------
    (..., 3, 3) float
    """
    omega = _elementary(angles[..., 0], 0)
    phi = _elementary(angles[..., 1], 1)
    kappa = _elementary(angles[..., 2], 2)
    if sequence == "omega-phi-kappa":
        return np.asarray(omega @ phi @ kappa)
    return np.asarray(phi @ omega @ kappa)


def angles_from_rotation(rotation: FloatArray, sequence: RotationSequence = "omega-phi-kappa") -> FloatArray:
    """Angles omega, phi, kappa of rotation matrices, (..., 3) radians.

    The second rotation of the sequence lies in [-pi/2, pi/2]; where it reaches the end, the third is set to 0.
    """
    r = rotation
    out = np.empty(r.shape[:-1])
    if sequence == "omega-phi-kappa":
        sine = np.clip(r[..., 0, 2], -1.0, 1.0)
        locked = np.abs(sine) > 1.0 - 1e-15
        out[..., 1] = np.arctan2(sine, np.hypot(r[..., 0, 0], r[..., 0, 1]))
        out[..., 0] = np.where(
            locked, np.arctan2(r[..., 2, 1], r[..., 1, 1]), np.arctan2(-r[..., 1, 2], r[..., 2, 2])
        )
        out[..., 2] = np.where(locked, 0.0, np.arctan2(-r[..., 0, 1], r[..., 0, 0]))
        return out
    sine = np.clip(-r[..., 1, 2], -1.0, 1.0)
    locked = np.abs(sine) > 1.0 - 1e-15
    out[..., 0] = np.arctan2(sine, np.hypot(r[..., 1, 0], r[..., 1, 1]))
    out[..., 1] = np.where(
        locked, np.arctan2(-r[..., 2, 0], r[..., 0, 0]), np.arctan2(r[..., 0, 2], r[..., 2, 2])
    )
    out[..., 2] = np.where(locked, 0.0, np.arctan2(r[..., 1, 0], r[..., 1, 1]))
    return out


def cross_matrix(vector: FloatArray) -> FloatArray:
    """[v]x with [v]x w = v x w, (..., 3, 3)."""
    matrix = np.zeros((*vector.shape, 3), dtype=vector.dtype)
    matrix[..., 0, 1], matrix[..., 0, 2] = -vector[..., 2], vector[..., 1]
    matrix[..., 1, 0], matrix[..., 1, 2] = vector[..., 2], -vector[..., 0]
    matrix[..., 2, 0], matrix[..., 2, 1] = -vector[..., 1], vector[..., 0]
    return matrix


def rotation_from_vector(theta: FloatArray) -> FloatArray:
    """exp([theta]x) by Rodrigues' formula, (..., 3, 3)."""
    square = np.sum(theta * theta, axis=-1)[..., None, None]
    norm = np.sqrt(square)
    small = np.abs(square) < 1e-8
    safe = np.where(small, 1.0, norm)
    a = np.where(small, 1.0 - square / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - square / 24.0, (1.0 - np.cos(safe)) / (safe * safe))
    k = cross_matrix(theta)
    return np.asarray(np.eye(3) + a * k + b * (k @ k))


def angle_jacobian(angles: FloatArray, sequence: RotationSequence = "omega-phi-kappa") -> FloatArray:
    """d(theta)/d(omega, phi, kappa): the photo-frame rotation vector of a small change of angles.

    The columns are the axes of the three elementary rotations, seen from the photo frame.  Singular where the
    second rotation of the sequence is +-90 degrees.

    Returns
    -------
    (..., 3, 3) float
    """
    kappa = _elementary(angles[..., 2], 2)
    kappa_t = np.swapaxes(kappa, -1, -2)
    jacobian = np.zeros((*angles.shape, 3))
    if sequence == "omega-phi-kappa":
        phi_t = np.swapaxes(_elementary(angles[..., 1], 1), -1, -2)
        jacobian[..., :, 0] = (kappa_t @ phi_t)[..., :, 0]
        jacobian[..., :, 1] = kappa_t[..., :, 1]
    else:
        omega_t = np.swapaxes(_elementary(angles[..., 0], 0), -1, -2)
        jacobian[..., :, 0] = kappa_t[..., :, 0]
        jacobian[..., :, 1] = (kappa_t @ omega_t)[..., :, 1]
    jacobian[..., 2, 2] = 1.0
    return jacobian


def wrap_angle(angle: FloatArray) -> FloatArray:
    """Angle reduced to [-pi, pi)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
