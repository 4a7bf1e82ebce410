"""Closed Fourier curves: X(u) = C + sum_k (A_k cos ku + B_k sin ku), u in [0, 2 pi).  Lee 2.3.2.

Values: C, A_1, B_1, A_2, B_2, ... (2 m + 1 rows).  u -> u + c maps the family onto itself: one null, the phase.
A curve that needs only q < m harmonics has 2 (m - q) more to the first order: u -> u + c cos ku + d sin ku, k up to
m - q, leaves the family in the second order only.  2 m - 1 conditions stand therefore at equal distances of u, of which
one alone is kept where every harmonic is needed.

The domain is divided into at least four segments for each period of the highest harmonic, so that the search for foot
points is dense enough.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import Curve, FloatArray

SEGMENTS_PER_PERIOD = 4
TURN = 2.0 * np.pi


def fourier(curve: Curve) -> CurveBasis:
    """Basis of a Fourier curve given by its centre and the vectors of its harmonics.

    Raises
    ------
    ValueError
        If the number of rows is not odd, or less than 3.
    """
    count = len(curve.values)
    if count < 3 or count % 2 == 0:
        raise ValueError(f"fourier needs an odd number of rows from 3, not {count}")
    return harmonic_basis(count, np.linspace(0.0, TURN, SEGMENTS_PER_PERIOD * (count // 2) + 1), closed=True)


def harmonic_basis(count: int, break_points: FloatArray, *, closed: bool) -> CurveBasis:
    """1, cos u, sin u, ... (count functions) on segments that all have the same coefficients."""
    segments = len(break_points) - 1
    return CurveBasis(
        break_points=break_points,
        power=np.tile(np.eye(count), (segments, 1, 1)),
        columns=np.tile(np.arange(count), (segments, 1)),
        value_columns=np.arange(count)[:, None],
        value_weights=np.ones((count, 1)),
        value_is_position=np.arange(count) == 0,
        coefficient_count=count,
        closed=closed,
        has_location=True,
        anchors=break_points[0] + TURN * np.arange(max(1, count - 2)) / max(1, count - 2),
        trigonometric=True,
    )
