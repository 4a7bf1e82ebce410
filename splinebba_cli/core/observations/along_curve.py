"""Equation along the projected curve of a measured point, the part that its location takes up.

With r = W (p(X(u)) - xy), A = W d(x, y)/dX and b = A X'(u), the row is b/|b| . r; its derivative over u is |b|.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class AlongRows:
    """Linearised equations along the curve, whitened."""

    residual: FloatArray  # (k,)
    slope: FloatArray  # (k,) d/du
    orientation: FloatArray  # (k, 6) d/d(theta, X0)
    segment: IntArray  # (k,)
    coefficients: FloatArray  # (k, w, 3) d/dP_j
    square: FloatArray  # (k,) squared distance of the measured point, across the curve included


def along_rows(prepared: Prepared, state: State, point: IntArray) -> AlongRows:
    """Equations along the projected curve of measured points (k,).

    Raises
    ------
    FloatingPointError
        If a curve point lies behind a camera.
    """
    observed, curves = prepared.network.curve_observations, prepared.curves
    image = observed.image[point]
    segment, t = curves.locate(observed.curve[point], state.location[point])
    weights = curves.weights(segment, t)
    local = state.coefficients[curves.columns[segment]]
    xyz = np.matmul(weights[:, None, :], local)[:, 0]
    tangent = np.matmul(curves.weights(segment, t, 1)[:, None, :], local)[:, 0]
    xy, jacobian = project_with_jacobian(
        prepared.principal_distance[image], state.rotation[image], state.position[image], xyz
    )
    whitening = prepared.curve_rays.whitening[point]
    r = np.matmul(whitening, (xy - prepared.curve_rays.xy[point])[:, :, None])[:, :, 0]
    if not np.isfinite(r).all():
        raise FloatingPointError("a curve point lies behind a camera")
    a_xyz = np.matmul(whitening, jacobian.object_xyz)
    b = np.matmul(a_xyz, tangent[:, :, None])[:, :, 0]
    speed = np.hypot(b[:, 0], b[:, 1])
    unit = np.where(speed[:, None] > 0.0, b / np.where(speed > 0.0, speed, 1.0)[:, None], [0.0, 1.0])
    direction = np.matmul(unit[:, None, :], a_xyz)[:, 0]
    return AlongRows(
        residual=np.sum(unit * r, axis=1),
        slope=speed,
        orientation=np.matmul(unit[:, None, :], np.matmul(whitening, jacobian.orientation))[:, 0],
        segment=segment,
        coefficients=weights[:, :, None] * direction[:, None, :],
        square=np.sum(r * r, axis=1),
    )
