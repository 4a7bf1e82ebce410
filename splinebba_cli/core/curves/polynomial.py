"""Polynomials of degree 0 to 3 in t on [0, 1], by their coefficients (Lee, table 5.2; 3.9 for one segment).

    X(t) = a_0 + a_1 t + ... + a_d t^d

The free cubic segment (d = 3) is Lee's segment of tables 5.4 to 5.12 with its twelve numbers.  t -> alpha t + beta
maps the family onto itself: two null directions for d >= 1, none for d = 0 (a point).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import Curve


def polynomial_basis(degree: int) -> CurveBasis:
    """Basis 1, t, ..., t^degree on one segment."""
    count = degree + 1
    power = np.zeros((1, 4, count))
    power[0, np.arange(count), np.arange(count)] = 1.0
    columns = np.arange(count)[None, :]
    return CurveBasis(
        break_points=np.array([0.0, 1.0]),
        power=power,
        columns=columns,
        value_columns=np.arange(count)[:, None],
        value_weights=np.ones((count, 1)),
        value_is_position=np.arange(count) == 0,
        coefficient_count=count,
        closed=False,
        has_location=degree > 0,
        anchors=np.array([0.0, 1.0]) if degree > 0 else np.zeros(0),
    )


def polynomial_0(curve: Curve) -> CurveBasis:
    """A point."""
    return polynomial_basis(0)


def polynomial_1(curve: Curve) -> CurveBasis:
    """A straight line by point and direction."""
    return polynomial_basis(1)


def polynomial_2(curve: Curve) -> CurveBasis:
    """A parabola."""
    return polynomial_basis(2)


def polynomial_3(curve: Curve) -> CurveBasis:
    """A cubic; the free cubic segment."""
    return polynomial_basis(3)
