"""Nearest point of a curve in object space: global search over samples, then Newton's method."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import FloatArray

SAMPLES_PER_SEGMENT = 32
STEPS = 20  # a step that leads away is refused, and the next one is shorter; else it may be longer


def nearest_on_curve(
    basis: CurveBasis, coefficients: FloatArray, points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Location and distance of the nearest curve point.

    Parameters
    ----------
    points : (n, 3) float, metres

    Returns
    -------
    u : (n,) float, clipped to the domain of an open curve
    distance : (n,) float, metres
    """
    breaks = basis.break_points
    steps = np.arange(SAMPLES_PER_SEGMENT) / SAMPLES_PER_SEGMENT
    samples = np.append((breaks[:-1, None] + steps * np.diff(breaks)[:, None]).ravel(), breaks[-1])
    xyz = basis.evaluate(samples, coefficients)
    u = np.empty(len(points))
    for begin in range(0, len(points), 1000):
        chunk = points[begin : begin + 1000]
        square = np.sum((chunk[:, None, :] - xyz[None, :, :]) ** 2, axis=2)
        u[begin : begin + 1000] = samples[np.argmin(square, axis=1)]
    segment, _ = basis.locate(u)
    reach = np.diff(breaks)[segment] / SAMPLES_PER_SEGMENT
    distance = np.linalg.norm(basis.evaluate(u, coefficients) - points, axis=1)
    for _ in range(STEPS):
        trial = u + np.clip(_newton_step(basis, coefficients, points, u), -reach, reach)
        if not basis.closed:
            trial = np.clip(trial, breaks[0], breaks[-1])
        new = np.linalg.norm(basis.evaluate(trial, coefficients) - points, axis=1)
        nearer = new <= distance
        u, distance = np.where(nearer, trial, u), np.where(nearer, new, distance)
        reach = np.where(nearer, 2.0, 0.25) * reach
    return u, distance


def _newton_step(
    basis: CurveBasis, coefficients: FloatArray, points: FloatArray, u: FloatArray
) -> FloatArray:
    """Step of u towards the foot point, (X - p)ᵀ X' = 0, (n,)."""
    difference = basis.evaluate(u, coefficients) - points
    first, second = basis.evaluate(u, coefficients, 1), basis.evaluate(u, coefficients, 2)
    square = np.sum(first * first, axis=1)
    hessian = square + np.sum(difference * second, axis=1)
    curvature = np.where(hessian > 0.2 * square, hessian, np.maximum(square, 1e-300))
    return np.asarray(-np.sum(difference * first, axis=1) / curvature)
