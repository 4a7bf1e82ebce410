"""v'Pv by the peer's rule, at the solution of this program.

The peer never leaves the segment in which a point was generated: beyond its ends it goes on along the polynomial of
that segment, where this program goes on to the next segment (or to the natural end).  Only points measured next to a
joint differ; with this rule both programs must find the same v'Pv.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.collinearity import project, project_with_jacobian
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State

STEPS = 12


def cost_difference(prepared: Prepared, state: State, segment: IntArray) -> float:
    """v'Pv of the curve points by the peer's rule, minus that by ours.

    Parameters
    ----------
    segment : (n,) the segment of every measured point within its curve, as generated
    """
    observed, curves = prepared.network.curve_observations, prepared.curves
    image, c = observed.image, prepared.principal_distance[observed.image]
    number = curves.segment_start[observed.curve] + segment
    polynomials = curves.segment_polynomials(state.coefficients)
    t = (state.location - curves.left[number]) / curves.length[number]
    square = np.zeros(len(t))
    for _ in range(STEPS):
        xyz, rate, _ = curves.derivatives(polynomials, number, t)
        xy, jacobian = project_with_jacobian(c, state.rotation[image], state.position[image], xyz)
        along = _times(prepared.curve_rays.whitening, _times(jacobian.object_xyz, rate))
        residual = _times(prepared.curve_rays.whitening, xy - prepared.curve_rays.xy)
        step = np.sum(along * residual, axis=1) / np.sum(along**2, axis=1)
        square = np.sum(residual**2, axis=1)
        t = t - step / curves.length[number]
    return float(np.sum(square - squared_distance(prepared, state)))


def squared_distance(prepared: Prepared, state: State) -> FloatArray:
    """Whitened squared distance of every measured point to its curve point, (n,)."""
    observed, image = prepared.network.curve_observations, prepared.network.curve_observations.image
    xyz = prepared.curves.evaluate(state.coefficients, observed.curve, state.location)[0]
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    residual = _times(prepared.curve_rays.whitening, xy - prepared.curve_rays.xy)
    return np.asarray(np.sum(residual**2, axis=1))


def _times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    return np.asarray(np.matmul(matrix, vector[:, :, None])[:, :, 0])
