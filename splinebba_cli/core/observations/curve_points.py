"""Image points on curves: extended collinearity (Lee 3.12-3.18), the location eliminated on the spot.

With whitened residual r = W (p(X(u)) - xy), A = W d(x, y)/dX and b = A X'(u), the unit vector n, n . b = 0, turns two
equations with the unknown location into one without it,

    n'(r + A_eop d_eop + sum_j N_j A dP_j) = n'v .

Its Jacobian over the coefficients is the outer product of the basis weights N (w) and g = n'A (3).  Where a location
is held at the end of its domain (or the curve is a point), the equation along b stays as a second row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State

UNSETTLED = 1e-6  # residual along the curve, in sigma, above which a location is no foot point


@dataclass(frozen=True)
class CurveRows:
    """Linearised equations without locations; row k belongs to measured point ``point[k]``."""

    point: IntArray  # (k,) measured point; the first n rows are the equations across, in the order of points
    image: IntArray  # (k,)
    segment: IntArray  # (k,) segment number in the curve set
    residual: FloatArray  # (k,) whitened
    orientation: FloatArray  # (k, 6) d/d(theta, X0)
    weights: FloatArray  # (k, w) basis values
    direction: FloatArray  # (k, 3) d/dX; d/dP_j = N_j direction
    along: FloatArray  # (n,) whitened residual along the curve (0 at the foot point)
    speed: FloatArray  # (n,) |b|, whitened residual per unit of u
    normal: FloatArray  # (n, 2) whitened unit normal
    cost: float  # sum of squares that remains after the elimination


def linearize_curve_points(
    prepared: Prepared, state: State, held: IntArray, points: IntArray | None = None
) -> CurveRows:
    """Equations across the curves at the current state.

    Parameters
    ----------
    points : (n,) int, the measured points that are wanted, None for all
    held : (h,) int, measured points whose location is held: they keep the equation along the curve, and so
        does every other point whose location is not (yet) its foot point.  Linked points have theirs in
        :mod:`~splinebba_cli.core.observations.linked_points`

    Raises
    ------
    FloatingPointError
        If a point of a curve lies behind a camera.
    """
    observed, curves = prepared.network.curve_observations, prepared.curves
    chosen = np.arange(len(observed)) if points is None else points
    image = observed.image[chosen]
    segment, t = curves.locate(observed.curve[chosen], state.location[chosen])
    weights = curves.weights(segment, t)
    local = state.coefficients[curves.columns[segment]]
    xyz = np.matmul(weights[:, None, :], local)[:, 0]
    tangent = np.matmul(curves.weights(segment, t, 1)[:, None, :], local)[:, 0]
    xy, jacobian = project_with_jacobian(
        prepared.principal_distance[image], state.rotation[image], state.position[image], xyz
    )
    whitening = prepared.curve_rays.whitening[chosen]
    r = np.matmul(whitening, (xy - prepared.curve_rays.xy[chosen])[:, :, None])[:, :, 0]
    if not np.isfinite(r).all():
        raise FloatingPointError("a curve point lies behind a camera")
    a_xyz = np.matmul(whitening, jacobian.object_xyz)
    a_eop = np.matmul(whitening, jacobian.orientation)
    b = np.matmul(a_xyz, tangent[:, :, None])[:, :, 0]
    speed = np.hypot(b[:, 0], b[:, 1])
    moving = speed > 0.0
    unit = np.where(moving[:, None], b / np.where(moving, speed, 1.0)[:, None], [0.0, 1.0])
    normal = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    along = np.sum(unit * r, axis=1)
    is_held = np.zeros(len(observed), dtype=bool)
    is_held[held] = True
    with_along = is_held[chosen] | (np.abs(along) > UNSETTLED)
    fixed = np.flatnonzero(with_along & ~prepared.chains.linked[chosen])
    rows = np.concatenate([np.arange(len(image)), fixed])
    project_on = np.concatenate([normal, unit[fixed]])
    residual = np.sum(project_on * r[rows], axis=1)
    return CurveRows(
        point=chosen[rows],
        image=image[rows],
        segment=segment[rows],
        residual=residual,
        orientation=np.matmul(project_on[:, None, :], a_eop[rows])[:, 0],
        weights=weights[rows],
        direction=np.matmul(project_on[:, None, :], a_xyz[rows])[:, 0],
        along=along,
        speed=speed,
        normal=normal,
        cost=float(residual @ residual),
    )
