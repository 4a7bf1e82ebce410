"""Second-order part of the elimination of locations at sharp turns.

The location of a measured point has the exact second derivative h = b . b + r . r'', with r' = b.  Eliminating it
with h instead of b . b leaves the share 1 - b . b / h of the equation along the curve in the normal matrix: at a
corner a point on the outer side holds the corner itself.  The residual along the curve is 0 at a foot point, so that
these rows change steps, not the solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.projected_places import projected_derivatives
from splinebba_cli.core.state import Prepared, State

SHARE = 0.05  # of the equation along the curve that is worth keeping


@dataclass(frozen=True)
class SecondOrderRows:
    """Rows along the curve, whitened and scaled by the root of their share; residual 0."""

    point: IntArray  # (q,) measured points
    image: IntArray  # (q,)
    segment: IntArray  # (q,) segment number in the curve set
    orientation: FloatArray  # (q, 6) d/d(theta, X0)
    weights: FloatArray  # (q, w) basis values
    direction: FloatArray  # (q, 3) d/dX; d/dP_j = N_j direction


def second_order_rows(prepared: Prepared, state: State) -> SecondOrderRows:
    """Rows of all measured points whose share is worth its cost, at their foot points."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    polynomials = curves.segment_polynomials(state.coefficients)
    every = np.flatnonzero(~prepared.chains.linked)
    r, r1, r2, _ = projected_derivatives(prepared, state, polynomials, every, state.location[every])
    square = np.sum(r1 * r1, axis=1)
    bend = np.sum(r * r2, axis=1)
    share = np.divide(bend, square + bend, out=np.zeros_like(bend), where=bend > 1e-12)
    worth = share > SHARE
    rows, share, square, r1 = every[worth], share[worth], square[worth], r1[worth]
    image = observed.image[rows]
    segment, t = curves.locate(observed.curve[rows], state.location[rows])
    weights = curves.weights(segment, t)
    xyz = np.matmul(weights[:, None, :], state.coefficients[curves.columns[segment]])[:, 0]
    _, jacobian = project_with_jacobian(
        prepared.principal_distance[image], state.rotation[image], state.position[image], xyz
    )
    along = r1 * np.sqrt(share / square)[:, None]
    project_on = np.matmul(along[:, None, :], prepared.curve_rays.whitening[rows])
    return SecondOrderRows(
        point=rows,
        image=image,
        segment=segment,
        orientation=np.matmul(project_on, jacobian.orientation)[:, 0],
        weights=weights,
        direction=np.matmul(project_on, jacobian.object_xyz)[:, 0],
    )
