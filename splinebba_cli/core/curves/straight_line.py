"""Straight line by two points, X(u) = (1 - u) P_0 + u P_1; two null directions, both along the line."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import Curve


def straight_line(curve: Curve) -> CurveBasis:
    """Basis of a straight line given by two of its points."""
    power = np.zeros((1, 4, 2))
    power[0, 0, 0], power[0, 1, 0], power[0, 1, 1] = 1.0, -1.0, 1.0
    return CurveBasis(
        break_points=np.array([0.0, 1.0]),
        power=power,
        columns=np.array([[0, 1]]),
        value_columns=np.array([[0], [1]]),
        value_weights=np.ones((2, 1)),
        value_is_position=np.ones(2, dtype=bool),
        coefficient_count=2,
        closed=False,
        has_location=True,
        anchors=np.array([0.0, 1.0]),
    )
