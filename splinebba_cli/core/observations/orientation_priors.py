"""Prior exterior orientations (GNSS/INS): (angle or coordinate - prior) / sigma, per component.

The Jacobian of the angles over the solver's rotation vector is the inverse of
:func:`~splinebba_cli.core.camera.rotation.angle_jacobian`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.rotation import angle_jacobian, angles_from_rotation, wrap_angle
from splinebba_cli.core.network import BoolArray, FloatArray, Images, IntArray
from splinebba_cli.core.state import State


@dataclass(frozen=True)
class PriorRows:
    """Six rows an image; rows without a prior are zero."""

    image: IntArray  # (q,)
    residual: FloatArray  # (q, 6) whitened
    jacobian: FloatArray  # (q, 6, 6) d/d(theta, X0)
    active: BoolArray  # (q, 6)
    cost: float


HELD_ANGLE = 1e-9  # sigma of an angle that is fixed while others of its image are not, rad


def weighting_sigma(images: Images) -> FloatArray:
    """Sigma of all priors, (m, 6); a single fixed angle becomes an equation of very large weight.

    Angles are no unknowns of the solver: they can be removed only all three together.
    """
    sigma = images.prior_sigma.copy()
    single = (sigma[:, :3] == 0.0) & (sigma[:, :3] != 0.0).any(axis=1)[:, None]
    sigma[:, :3] = np.where(single, HELD_ANGLE, sigma[:, :3])
    return sigma


def linearize_orientation_priors(images: Images, state: State) -> PriorRows:
    """Equations of the weighted priors at the current state."""
    sigma = weighting_sigma(images)
    weighted = np.isfinite(sigma) & (sigma > 0.0)
    rows = np.flatnonzero(weighted.any(axis=1))
    active = weighted[rows]
    inverse_sigma = np.where(active, 1.0 / np.where(active, sigma[rows], 1.0), 0.0)
    difference = np.zeros((len(rows), 6))
    jacobian = np.zeros((len(rows), 6, 6))
    jacobian[:, [3, 4, 5], [3, 4, 5]] = 1.0
    sequences = np.array(images.sequence)[rows]
    for sequence in images.sequences:
        own = np.flatnonzero((sequences == sequence) & active[:, :3].any(axis=1))
        angles = angles_from_rotation(state.rotation[rows[own]], sequence)
        difference[own, :3] = wrap_angle(angles - np.nan_to_num(images.prior[rows[own], :3]))
        jacobian[own, :3, :3] = np.linalg.inv(angle_jacobian(angles, sequence))
    difference[:, 3:] = state.position[rows] - np.nan_to_num(images.prior[rows, 3:])
    residual = difference * inverse_sigma
    return PriorRows(
        image=rows,
        residual=residual,
        jacobian=jacobian * inverse_sigma[:, :, None],
        active=active,
        cost=float(np.sum(residual * residual)),
    )
