"""Guard against folding: between two knots a curve must not turn back on itself.

A natural spline whose knots slide may run forth, back and forth again between two knots (theory, section 6).  Its
tangent then turns by about 360 degrees within one segment; a true hairpin turns by 180, a true corner by less.
Curves of a single segment have no inner knots and cannot fold this way, nor can trigonometric ones.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER, power_row
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.state import Prepared

SAMPLES = np.linspace(0.0, 1.0, 13)
LARGEST_TURN = np.radians(250.0)  # within one segment


def folded_segments(prepared: Prepared, coefficients: FloatArray) -> IntArray:
    """Number of segments of every curve in which it turns back on itself, (nc,)."""
    curves = prepared.curves
    count = len(curves.bases)
    curve = np.repeat(np.arange(count), np.diff(curves.segment_start))
    return np.bincount(curve[folding_segments(prepared, coefficients)], minlength=count)


def folding_segments(prepared: Prepared, coefficients: FloatArray) -> IntArray:
    """Segments in which a curve turns back on itself, numbers in the curve set."""
    curves = prepared.curves
    if not len(curves.left):
        return np.zeros(0, dtype=np.int64)
    segments = np.diff(curves.segment_start)
    inner = np.repeat(segments > 1, segments)
    local = curves.segment_polynomials(coefficients)[:, :MAX_POWER]  # (S, 4, 3) power form
    suspect = np.flatnonzero(inner & ~curves.trigonometric & _may_turn_back(local))
    derivative = np.matmul(power_row(SAMPLES, 1), local[suspect])  # (q, 13, 3)
    norm = np.linalg.norm(derivative, axis=2)
    tangent = derivative / np.maximum(norm, 1e-300)[:, :, None]
    cosine = np.sum(tangent[:, 1:] * tangent[:, :-1], axis=2)
    turn = np.arccos(np.clip(cosine, -1.0, 1.0)).sum(axis=1)
    return np.asarray(suspect[turn > LARGEST_TURN])


def _may_turn_back(local: FloatArray) -> BoolArray:
    """Whether the three legs of the Bezier polygon of each segment are not all within 90 degrees of each other, (S,).

    The derivative is a mean of the legs with positive weights: where they are, the tangent turns by less.
    """
    first, second = local[:, 1], local[:, 1] + local[:, 2]
    third = second + local[:, 2] + 3.0 * local[:, 3]
    closest = np.minimum.reduce(
        [np.sum(a * b, axis=1) for a, b in ((first, second), (second, third), (first, third))]
    )
    return np.asarray(closest <= 0.0)
