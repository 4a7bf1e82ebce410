"""Cardinal splines through their knots, open or closed; with tension 0 Catmull-Rom splines.  Lee 2.3.1.

Cubic Hermite segments whose tangent at a knot follows from its neighbours,

    X'(u_i) = (1 - tension) (P_{i+1} - P_{i-1}) / (u_{i+1} - u_{i-1}),

one-sided at the ends of an open curve.  Knots are the coefficients; four of them act on a segment; C1 everywhere.

Nulls: none where the curve is not straight, because the knots' parameters are tied to their tangents; one for every
knot of a straight one, and two for a single segment, which is a straight line.  Knots slide nearly freely as those of
natural splines do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.curves.bspline_tables import folded
from splinebba_cli.core.network import Curve, FloatArray, IntArray

# powers 1, t, t^2, t^3 (rows) of P_i, P_{i+1} and of the tangents times the segment's length
HERMITE = np.array(
    [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-3.0, 3.0, -2.0, -1.0], [2.0, -2.0, 1.0, 1.0]]
)


def cardinal(curve: Curve) -> CurveBasis:
    """Basis of a cardinal spline given by its knots.

    Raises
    ------
    ValueError
        If there are too few knots, or the tension is outside of [-1, 1).
    """
    count = len(curve.values)
    if count < (3 if curve.closed else 2):
        raise ValueError(f"{curve.family} needs {3 if curve.closed else 2} rows, not {count}")
    if not -1.0 <= curve.tension < 1.0:
        raise ValueError(f"a tension lies in [-1, 1), not {curve.tension:g}")
    parameters = knot_parameters(curve.values, curve.parameterization, curve.closed, curve.knot_parameters)
    power, columns = _tables(parameters, curve.closed, 1.0 - curve.tension)
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
        anchors=parameters[:count],
    )


def catmull_rom(curve: Curve) -> CurveBasis:
    """A cardinal spline of tension 0."""
    return cardinal(replace(curve, tension=0.0))


def _tables(parameters: FloatArray, closed: bool, factor: float) -> tuple[FloatArray, IntArray]:
    segments = len(parameters) - 1
    knots = segments if closed else segments + 1
    number = np.arange(segments)[:, None] + np.arange(-1, 3)  # P_{i-1} .. P_{i+2}
    columns = number % knots if closed else np.clip(number, 0, knots - 1)
    length = np.diff(parameters)
    period = parameters[-1] - parameters[0]
    place = parameters[columns] + (period * (number // knots) if closed else 0.0)
    power = np.zeros((segments, 4, 4))
    power[:, :, 1], power[:, :, 2] = HERMITE[:, 0], HERMITE[:, 1]
    for tangent, (before, after) in enumerate(((0, 2), (1, 3))):
        weight = factor * length / (place[:, after] - place[:, before])
        power[:, :, after] += weight[:, None] * HERMITE[:, 2 + tangent]
        power[:, :, before] -= weight[:, None] * HERMITE[:, 2 + tangent]
    return folded(power, columns)
