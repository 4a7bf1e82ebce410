"""Dispersion of exterior orientations in the angles of the user: chain rule from the solver's rotation vector.

d(omega, phi, kappa) = J^-1 theta,   J = angle_jacobian .
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.rotation import angle_jacobian, angles_from_rotation
from splinebba_cli.core.network import FloatArray, Images


def eop_values(images: Images, rotation: FloatArray, position: FloatArray) -> FloatArray:
    """omega, phi, kappa (rad), X0, Y0, Z0 (m, local) of all images, (m, 6)."""
    out = np.empty((len(images.ids), 6))
    out[:, 3:] = position
    for sequence in set(images.sequence):
        rows = np.flatnonzero([s == sequence for s in images.sequence])
        out[rows, :3] = angles_from_rotation(rotation[rows], sequence)
    return out


def eop_dispersion(images: Images, rotation: FloatArray, blocks: FloatArray) -> FloatArray:
    """Blocks (m, 6, 6) of (theta, X0) turned into blocks of (omega, phi, kappa, X0)."""
    transform = eop_transform(images, rotation)
    return transform @ blocks @ transform.transpose(0, 2, 1)


def eop_transform(images: Images, rotation: FloatArray) -> FloatArray:
    """d(omega, phi, kappa, X0) / d(theta, X0), (m, 6, 6)."""
    transform = np.zeros((len(images.ids), 6, 6))
    transform[:, [3, 4, 5], [3, 4, 5]] = 1.0
    for sequence in set(images.sequence):
        rows = np.flatnonzero([s == sequence for s in images.sequence])
        jacobian = angle_jacobian(angles_from_rotation(rotation[rows], sequence), sequence)
        transform[rows, :3, :3] = np.linalg.pinv(jacobian)
    return transform
