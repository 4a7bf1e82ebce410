"""Guard against folding: between two knots a curve must not turn back on itself.

A natural spline whose knots slide may run forth, back and forth again between two knots (theory, section 6).  Its
tangent then turns by about 360 degrees within one segment; a true hairpin turns by 180, a true corner by less.
Curves of a single segment have no inner knots and cannot fold this way, nor can trigonometric ones.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER, power_row
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared

SAMPLES = np.linspace(0.0, 1.0, 13)
LARGEST_TURN = np.radians(250.0)  # within one segment


def folded_segments(prepared: Prepared, coefficients: FloatArray) -> IntArray:
    """Number of segments of every curve in which it turns back on itself, (nc,)."""
    curves = prepared.curves
    count = len(curves.bases)
    if not len(curves.left):
        return np.zeros(count, dtype=np.int64)
    local = curves.segment_polynomials(coefficients)[:, :MAX_POWER]  # (S, 4, 3) power form
    derivative = np.matmul(power_row(SAMPLES, 1), local)  # (S, 13, 3)
    norm = np.linalg.norm(derivative, axis=2)
    tangent = derivative / np.maximum(norm, 1e-300)[:, :, None]
    cosine = np.sum(tangent[:, 1:] * tangent[:, :-1], axis=2)
    turn = np.arccos(np.clip(cosine, -1.0, 1.0)).sum(axis=1)
    segments = np.diff(curves.segment_start)
    curve = np.repeat(np.arange(count), segments)
    folded = (turn > LARGEST_TURN) & (segments[curve] > 1) & ~curves.trigonometric
    return np.bincount(curve[folded], minlength=count)
