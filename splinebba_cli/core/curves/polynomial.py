"""Polynomials of degree 0 to 3 in t on [0, 1] of one or several segments, by their coefficients (Lee, table 5.2; 3.9).

    X(t) = a_0 + a_1 t + ... + a_d t^d   on every segment

Values: a_0 .. a_d of the first segment, then of the second, and so on, whatever the continuity.  The free cubic segment
(d = 3) is Lee's segment of tables 5.4 to 5.12 with its twelve numbers.

Continuity is exact: the coefficients of joined segments are those of the B-spline whose inner knots are repeated
d - k times (C^k), with natural ends those of a natural spline.  Of n cubic segments, 4n (C-1), 3n + 1 (C0), 2n + 2
(C1), n + 3 (C2) or n + 1 (natural) are left.  Derivatives are those over u: with unequal knot parameters the a_1 of
neighbours differ by the ratio of their lengths.

u -> alpha u + beta of every segment maps unjoined ones onto themselves: two nulls a segment for d >= 1.  Joints take
them away: n + 1 with C0, 2 with C1 (one map for all), with C2 one for two segments and none for more or with natural
ends.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER, CurveBasis, knot_parameters
from splinebba_cli.core.curves.bspline_tables import bspline_power_tables, clamped
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray

INSIDE = 1e-3  # of a segment: anchors of unjoined segments keep away from the joint, where two curves meet


def polynomial_basis(
    degree: int, parameters: FloatArray, continuity: int = -1, *, natural: bool = False
) -> CurveBasis:
    """Basis of polynomial segments.

    Parameters
    ----------
    parameters : (n + 1,) float, strictly ascending
    continuity : -1 to degree - 1
    natural : X'' = 0 at both ends; degree 3, C2 or a single segment
    """
    segments = len(parameters) - 1
    rows = degree + 1
    if natural:
        basis = natural_cubic_basis(parameters)
        power, columns = basis.power, basis.columns
    elif continuity < 0 or segments == 1:
        power = np.zeros((segments, MAX_POWER, rows))
        power[:, np.arange(rows), np.arange(rows)] = 1.0
        columns = np.arange(segments * rows).reshape(segments, rows)
    else:
        power, columns = bspline_power_tables(clamped(parameters, degree, continuity), degree)
    value_columns, value_weights = _values(power[:, :rows], columns)
    joined = continuity >= 0 or natural
    return CurveBasis(
        break_points=parameters,
        power=power,
        columns=columns,
        value_columns=value_columns,
        value_weights=value_weights,
        value_is_position=np.arange(segments * rows) % rows == 0,
        coefficient_count=int(columns.max()) + 1,
        closed=False,
        has_location=degree > 0,
        anchors=np.zeros(0) if degree == 0 else parameters if joined else _inside_segments(parameters, rows),
        loose_anchors=np.zeros(0, dtype=bool) if joined else _between_ends(segments, rows),
    )


def _values(power: FloatArray, columns: IntArray) -> tuple[IntArray, FloatArray]:
    """a_0 .. a_d of all segments as rows over the coefficients; one slot where the rows are the coefficients."""
    width = columns.shape[1]
    if power.shape[1] == width and (power == np.eye(width)).all():
        return columns.reshape(-1, 1), np.ones((columns.size, 1))
    return np.repeat(columns, power.shape[1], axis=0), power.reshape(-1, width)


def _inside_segments(parameters: FloatArray, count: int) -> FloatArray:
    """Evenly spaced places of every segment, as many as it has coefficients; those at joints a little inside.

    Those at the ends fill the exact defect.  The others hold a cubic or parabola that its measurements do not keep from
    sliding along itself unevenly (u -> u + e u (1 - u) is nearly one of its maps); they are dropped where they do.
    """
    t = np.linspace(0.0, 1.0, count)
    t = np.where(t == 0.0, INSIDE, np.where(t == 1.0, 1.0 - INSIDE, t))
    places = parameters[:-1, None] + t * np.diff(parameters)[:, None]
    places[0, 0], places[-1, -1] = parameters[0], parameters[-1]
    return places.ravel()


def _between_ends(segments: int, count: int) -> BoolArray:
    """Which anchors of unjoined segments are not at an end, (segments * count,)."""
    place = np.arange(segments * count) % count
    return np.asarray((place > 0) & (place < count - 1))


def _of_curve(curve: Curve, degree: int) -> CurveBasis:
    rows, segments = degree + 1, len(curve.values) // (degree + 1)
    if segments < 1 or len(curve.values) != segments * rows or (degree == 0 and segments > 1):
        raise ValueError(f"{curve.family} needs {rows} rows a segment, not {len(curve.values)}")
    if not -1 <= curve.continuity <= max(degree - 1, -1):
        raise ValueError(f"segments of {curve.family} cannot be joined C{curve.continuity}")
    if curve.natural_ends and (degree != 3 or (curve.continuity != 2 and segments > 1)):
        raise ValueError("natural ends belong to cubic segments joined C2")
    parameters = knot_parameters(np.zeros((segments + 1, 3)), "uniform", False, curve.knot_parameters)
    return polynomial_basis(degree, parameters, curve.continuity, natural=curve.natural_ends)


def polynomial_0(curve: Curve) -> CurveBasis:
    """A point."""
    return _of_curve(curve, 0)


def polynomial_1(curve: Curve) -> CurveBasis:
    """Straight lines by point and direction."""
    return _of_curve(curve, 1)


def polynomial_2(curve: Curve) -> CurveBasis:
    """Parabolas."""
    return _of_curve(curve, 2)


def polynomial_3(curve: Curve) -> CurveBasis:
    """Cubics; the free cubic segment."""
    return _of_curve(curve, 3)
