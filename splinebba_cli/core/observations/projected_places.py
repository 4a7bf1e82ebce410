"""Places of projected curves with their derivatives, and Newton's method to the nearest one, point by point.

Along the projected curve p(u), with whitened r(u) = W (p(u) - xy), the squared distance is stationary where
r . r' = 0; Newton's method uses the exact second derivative.  (theory, section 3)
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State

CHUNK = 8192  # points at once


def newton_step(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """One safeguarded Newton step; whether each point has settled to rounding."""
    r, r1, r2, length = projected_derivatives(prepared, state, polynomials, rows, location)
    gradient, square = np.sum(r * r1, axis=1), np.sum(r1 * r1, axis=1)
    hessian = square + np.sum(r * r2, axis=1)
    curvature = np.where(hessian > 0.2 * square, hessian, square)
    step = -gradient / np.where(curvature > 0.0, curvature, 1.0)
    limit = length / 8.0
    step = np.clip(np.where(np.isfinite(step), step, 0.0), -limit, limit)
    return location + step, np.abs(step) * np.sqrt(square) < 1e-10


def projected_derivatives(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Whitened residual r = W (p(u) - xy), its first and second derivative d/du, and the length of the segments.

    Parameters
    ----------
    polynomials : (S, K, 3) of the present segments (:meth:`CurveSet.segment_polynomials`)
    rows : (k,) measured points
    location : (k,) their locations

    Returns
    -------
    r, r1, r2 : (k, 2) float
    length : (k,) float, in units of u
    """
    r, r1, r2 = (np.empty((len(rows), 2)) for _ in range(3))
    length = np.empty(len(rows))
    for begin in range(0, len(rows), CHUNK):
        part = slice(begin, begin + CHUNK)
        r[part], r1[part], r2[part], length[part] = _chunk_derivatives(
            prepared, state, polynomials, rows[part], location[part]
        )
    return r, r1, r2, length


def _chunk_derivatives(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The same for as many points as stay in the cache; component by component."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    image = observed.image[rows]
    segment, t = curves.locate(observed.curve[rows], location)
    length = curves.length[segment]
    value, first, second = curves.derivatives(polynomials, segment, t)
    value -= state.position[image]
    rotation = state.rotation[image]
    p, p1, p2 = (
        [
            v[:, 0] * rotation[:, 0, k] + v[:, 1] * rotation[:, 1, k] + v[:, 2] * rotation[:, 2, k]
            for k in range(3)
        ]
        for v in (value, first, second)
    )
    inverse = 1.0 / p[2]
    scale = -prepared.principal_distance[image] * inverse
    xy = prepared.curve_rays.xy[rows]
    found = []
    for k in range(2):
        along = p[k] * inverse
        slope = p1[k] - along * p1[2]
        bend = p2[k] - along * p2[2] - 2.0 * slope * p1[2] * inverse
        found.append((scale * p[k] - xy[:, k], scale * slope, scale * bend))
    whitening = prepared.curve_rays.whitening[rows]
    r, r1, r2 = (
        np.stack([whitening[:, k, 0] * x + whitening[:, k, 1] * y for k in range(2)], axis=1)
        for x, y in zip(*found, strict=True)
    )
    return r, r1, r2, length
