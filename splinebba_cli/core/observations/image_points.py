"""Image points of object points: collinearity (Lee 3.12), whitened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class PointRows:
    """Linearised equations of image points, two per point."""

    residual: FloatArray  # (n, 2) whitened
    orientation: FloatArray  # (n, 2, 6) d/d(theta, X0)
    object_xyz: FloatArray  # (n, 2, 3) d/dX
    cost: float


def linearize_image_points(prepared: Prepared, state: State) -> PointRows:
    """Equations of all image points at the current state.

    Raises
    ------
    FloatingPointError
        If an object point lies behind a camera.
    """
    observed = prepared.network.point_observations
    image = observed.image
    xy, jacobian = project_with_jacobian(
        prepared.principal_distance[image],
        state.rotation[image],
        state.position[image],
        state.xyz[observed.point],
    )
    rays = prepared.point_rays
    r = np.matmul(rays.whitening, (xy - rays.xy)[:, :, None])[:, :, 0]
    if not np.isfinite(r).all():
        raise FloatingPointError("an object point lies behind a camera")
    return PointRows(
        residual=r,
        orientation=np.matmul(rays.whitening, jacobian.orientation),
        object_xyz=np.matmul(rays.whitening, jacobian.object_xyz),
        cost=float(np.sum(r * r)),
    )
