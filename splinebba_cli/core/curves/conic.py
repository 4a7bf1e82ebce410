"""Ellipses and circles: X(u) = C + A cos u + B sin u, whole (closed) or an arc between two given u (radians).

Values: C, A, B; A and B are any two conjugate radius vectors.  A closed bounded conic is always an ellipse; a circle
has besides |A| = |B| and A . B = 0, two shape conditions that are quadratic in the coefficients.
u -> u + c maps the family onto itself: one null, the phase, and one condition at the first u.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.fourier import SEGMENTS_PER_PERIOD, TURN, harmonic_basis
from splinebba_cli.core.network import Curve, FloatArray

# 1/2 p' K p over C, A, B: (|A|^2 - |B|^2) / 2 and A . B
CIRCLE_FORMS = np.array(
    [np.diag([0.0, 1.0, -1.0]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])]
)


def conic(curve: Curve) -> CurveBasis:
    """Basis of an ellipse or, with two knot parameters, of an elliptic arc.

    Raises
    ------
    ValueError
        If there are not three rows, or the arc is empty or more than a turn.
    """
    if len(curve.values) != 3:
        raise ValueError(f"{curve.family} needs 3 rows, not {len(curve.values)}")
    ends = curve.knot_parameters
    if ends is None:
        return harmonic_basis(3, np.linspace(0.0, TURN, SEGMENTS_PER_PERIOD + 1), closed=True)
    if len(ends) != 2 or not 0.0 < ends[1] - ends[0] <= TURN:
        raise ValueError("an arc has two knot parameters u_first < u_last, at most a turn apart (radians)")
    return harmonic_basis(3, arc_parameters(ends), closed=False)


def circle(curve: Curve) -> CurveBasis:
    """Basis of a circle or circular arc: a conic with two shape conditions."""
    return replace(conic(curve), shape_forms=CIRCLE_FORMS)


def arc_parameters(ends: FloatArray) -> FloatArray:
    """Ends of equal segments of at most a quarter turn."""
    segments = max(1, int(np.ceil(SEGMENTS_PER_PERIOD * (ends[1] - ends[0]) / TURN - 1e-9)))
    return np.linspace(ends[0], ends[1], segments + 1)
