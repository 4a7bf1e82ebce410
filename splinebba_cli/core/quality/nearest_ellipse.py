"""The ellipse nearest to a closed curve, so that curves of different families can be told in the same terms.

Points at equal arc length along the curve are fitted by C + A cos u + B sin u: u starts as the share of the arc length
(the first harmonic: exact for a circle) and is then the foot point of every point on the ellipse, in turn with linear
least squares for C, A, B.  What is left is reported: a curve that is no ellipse is not near one.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, harmonic_row
from splinebba_cli.core.curves.fourier import TURN
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.conic_elements import conic_elements
from splinebba_cli.core.result import Ellipse

SAMPLES_PER_SEGMENT = 32
POINTS = 96
ROUNDS = 30
NEWTON_STEPS = 5
SETTLED = 1e-10  # change of the rms, relative to the size


def nearest_ellipse(basis: CurveBasis, coefficients: FloatArray) -> Ellipse:
    """Ellipse nearest to a closed curve, in the frame of its coefficients."""
    xyz = _evenly_spaced(basis, coefficients)
    u = TURN * np.arange(POINTS) / POINTS
    previous = np.inf
    for _ in range(ROUNDS):
        values = np.asarray(np.linalg.lstsq(harmonic_row(u, 0, 3), xyz, rcond=None)[0], dtype=np.float64)
        axes, directions, normal, _ = conic_elements(values)
        u, distance = _feet(xyz - values[0], axes, directions)
        rms = float(np.sqrt(np.mean(distance**2)))
        if abs(previous - rms) <= SETTLED * axes[0]:
            break
        previous = rms
    return Ellipse(values[0], axes, normal, rms, float(distance.max()))


def _feet(xyz: FloatArray, axes: FloatArray, directions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eccentric angles of the foot points on an ellipse about the origin, and distances, (n,) each.

    With p, q along the axes, (a^2 - b^2) sin u cos u - a p sin u + b q cos u = 0, by Newton's method.
    """
    a, b = axes
    p, q = directions @ xyz.T
    u = np.arctan2(a * q, b * p)
    for _ in range(NEWTON_STEPS):
        sine, cosine = np.sin(u), np.cos(u)
        value = (a * a - b * b) * sine * cosine - a * p * sine + b * q * cosine
        slope = (a * a - b * b) * (sine * sine - cosine * cosine) + a * p * cosine + b * q * sine
        safe = slope > 0.1 * (a * p * cosine + b * q * sine)
        u = u + np.where(safe, value / np.where(safe, slope, 1.0), 0.0)
    foot = a * np.cos(u)[:, None] * directions[0] + b * np.sin(u)[:, None] * directions[1]
    return u, np.linalg.norm(xyz - foot, axis=1)


def _evenly_spaced(basis: CurveBasis, coefficients: FloatArray) -> FloatArray:
    """Points at equal arc length, (POINTS, 3)."""
    breaks = basis.break_points
    share = np.arange(SAMPLES_PER_SEGMENT) / SAMPLES_PER_SEGMENT
    u = np.append((breaks[:-1, None] + share * np.diff(breaks)[:, None]).ravel(), breaks[-1])
    xyz = basis.evaluate(u, coefficients)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])
    return basis.evaluate(np.interp(length[-1] * np.arange(POINTS) / POINTS, length, u), coefficients)
