"""B-splines of degree 1, 2 and 3 by their control points, open (clamped) or closed (periodic).  Lee 2.3.1.

    X(u) = sum_j B_j,d(u) P_j

An open one begins and ends at its end control points and has as many segments as control points less the degree; a
closed one has a segment for every control point.  Knot parameters belong to the ends of the segments: one unit each,
or, by chord length, the mean of `degree` consecutive chord lengths of the control polygon (Piegl and Tiller, The NURBS
Book, eq. 9.8).  They are C^(degree - 1) at all knots.

Nulls: a curve of degree 1 with n segments is a chain of lines, whose inner control points are its corners and cannot
slide: the two ends alone do (2; closed: 0).  Of degree 2 and 3 one segment is a polynomial (2); two segments of equal
parameters leave one (see the rank table of joined polynomials), more none where the curve is not straight.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.curves.bspline_tables import bspline_power_tables, clamped, periodic_tables
from splinebba_cli.core.network import Curve, FloatArray

FEWEST_CLOSED = 3


def bspline_1(curve: Curve) -> CurveBasis:
    """A polygon."""
    return bspline_basis(curve, 1)


def bspline_2(curve: Curve) -> CurveBasis:
    """A chain of parabolas."""
    return bspline_basis(curve, 2)


def bspline_3(curve: Curve) -> CurveBasis:
    """A chain of cubics."""
    return bspline_basis(curve, 3)


def bspline_basis(curve: Curve, degree: int) -> CurveBasis:
    """Basis of a B-spline by its control points.

    Raises
    ------
    ValueError
        If there are too few control points.
    """
    count = len(curve.values)
    fewest = FEWEST_CLOSED if curve.closed else degree + 1
    if count < fewest:
        raise ValueError(f"{curve.family} needs {fewest} rows, not {count}")
    parameters = bspline_parameters(curve, degree)
    if curve.closed:
        power, columns = periodic_tables(parameters, degree)
    else:
        power, columns = bspline_power_tables(clamped(parameters, degree), degree)
    return CurveBasis(
        break_points=parameters,
        power=power,
        columns=columns,
        value_columns=np.arange(count)[:, None],
        value_weights=np.ones((count, 1)),
        value_is_position=np.ones(count, dtype=bool),
        coefficient_count=count,
        closed=curve.closed,
        has_location=True,
        anchors=parameters[:-1] if curve.closed else parameters,
    )


def bspline_parameters(curve: Curve, degree: int) -> FloatArray:
    """Parameters of the ends of the segments, (S + 1,)."""
    segments = len(curve.values) if curve.closed else len(curve.values) - degree
    if curve.knot_parameters is not None or curve.parameterization == "uniform":
        places = np.zeros((segments + (0 if curve.closed else 1), 3))
        return knot_parameters(places, "uniform", curve.closed, curve.knot_parameters)
    chords = knot_parameters(curve.values, "chord_length", curve.closed)
    if curve.closed:
        chords = np.concatenate([chords, chords[-1] + chords[1:degree]])
    means = np.convolve(chords, np.full(degree, 1.0 / degree), mode="valid")
    if curve.closed:
        return np.asarray(means - means[0], dtype=float)
    return np.concatenate([[0.0], means[1:-1], [chords[-1]]])
