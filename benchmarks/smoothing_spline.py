"""The smoothing spline of scipy with the fewest knots that keeps a largest distance."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, make_splprep

from splinebba_cli.core.network import FloatArray


def smoothing_spline(points: FloatArray, threshold: float, bisections: int = 24) -> tuple[int, float]:
    """Knots (both ends counted) and largest distance of the smoothest spline that keeps the threshold.

    The smoothing factor is found by bisection of its logarithm; distances are orthogonal to the curve; the
    parameter is the cumulated chord length, as in the fit that it is compared with.
    """
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    u = np.concatenate([[0.0], np.cumsum(chords)])
    low, high = 1e-12, 4.0 * len(points) * threshold**2
    best = (len(points), 0.0)
    for _ in range(bisections):
        factor = float(np.sqrt(low * high))
        spline, _ = make_splprep(points.T, u=u, s=factor)
        largest = float(orthogonal_distances(spline, u, points).max())
        if largest <= threshold:
            low, best = factor, (len(spline.t) - 2 * spline.k, largest)
        else:
            high = factor
        if high < 1.05 * low:
            break
    return best


def orthogonal_distances(spline: BSpline, u: FloatArray, points: FloatArray) -> FloatArray:
    """Distances of points from the curve, searched near their parameters, (n,)."""
    coefficients = np.asarray(spline.c)
    if len(coefficients) != len(spline.t) - spline.k - 1:
        coefficients = coefficients.T
    columns = BSpline(spline.t, np.ascontiguousarray(coefficients), spline.k)
    first, second = columns.derivative(1), columns.derivative(2)
    at = u.copy()
    for _ in range(6):
        residual, tangent = columns(at) - points, first(at)
        square = np.sum(tangent * tangent, axis=1)
        hessian = square + np.sum(residual * second(at), axis=1)
        hessian = np.where(hessian > 0.2 * square, hessian, square)
        at = np.clip(at - np.sum(residual * tangent, axis=1) / hessian, u[0], u[-1])
    return np.asarray(np.linalg.norm(columns(at) - points, axis=1))
