"""B-splines of any degree up to 3 in power form: what splines and joined polynomials are made of.

On the segment between two different neighbouring knots of an extended knot vector, degree + 1 B-splines are not zero;
de Boor's recursion runs on polynomials in t = (u - left) / (right - left).  A knot that is repeated r times leaves
continuity C^(degree - r).
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.network import FloatArray, IntArray


def bspline_power_tables(extended: FloatArray, degree: int = 3) -> tuple[FloatArray, IntArray]:
    """Power form of the B-splines on every segment of an extended knot vector.

    Parameters
    ----------
    extended : ascending knots, repeated ones allowed; the domain begins at number `degree`, and ends as far
        before the last one

    Returns
    -------
    power : (S, 4, degree + 1) float
        Power of t, B-spline.
    columns : (S, degree + 1) int
        Numbers of the B-splines.

    References
    ----------
    de Boor, A Practical Guide to Splines (1978), chapter X.
    """
    inner = np.arange(degree, len(extended) - degree - 1)
    segment = inner[extended[inner] < extended[inner + 1]]
    left, right = extended[segment], extended[segment + 1]
    length = right - left
    table = np.ones((len(segment), 1, 1))
    for order in range(1, degree + 1):
        new = np.zeros((len(segment), order + 1, order + 1))
        for j in range(order):  # lower function j supports new functions j and j + 1
            low, high = extended[segment + j - order + 1], extended[segment + 1 + j]
            span = high - low
            lower = table[:, :, j]
            falling_0, rising_0 = (high - left) / span, (left - low) / span
            slope = length / span
            new[:, :-1, j] += falling_0[:, None] * lower
            new[:, 1:, j] -= slope[:, None] * lower
            new[:, :-1, j + 1] += rising_0[:, None] * lower
            new[:, 1:, j + 1] += slope[:, None] * lower
        table = new
    power = np.zeros((len(segment), MAX_POWER, degree + 1))
    power[:, : degree + 1] = table
    return power, (segment - degree)[:, None] + np.arange(degree + 1)


def clamped(parameters: FloatArray, degree: int, continuity: int | None = None) -> FloatArray:
    """Extended knot vector of an open curve: end knots degree + 1 times, inner ones degree - continuity times."""
    times = 1 if continuity is None else degree - continuity
    ends = np.full(degree + 1, 1.0)
    return np.concatenate([parameters[0] * ends, np.repeat(parameters[1:-1], times), parameters[-1] * ends])


def periodic_tables(parameters: FloatArray, degree: int = 3) -> tuple[FloatArray, IntArray]:
    """Tables of a closed curve of as many coefficients as segments; parameters as for the curve, (n + 1,)."""
    n = len(parameters) - 1
    period = parameters[-1] - parameters[0]
    turns = np.arange(-degree, n + degree + 1)
    start = np.concatenate([[0.0], np.cumsum(np.diff(parameters))])[turns % n]
    power, _ = bspline_power_tables(parameters[0] + (turns // n) * period + start, degree)
    return folded(power, (np.arange(n)[:, None] + np.arange(degree + 1)) % n)


def folded(power: FloatArray, columns: IntArray) -> tuple[FloatArray, IntArray]:
    """Tables in which a coefficient that stands in two slots of a segment has its weights in the first one."""
    power = power.copy()
    for later in range(1, columns.shape[1]):
        for earlier in range(later):
            same = columns[:, earlier] == columns[:, later]
            power[same, :, earlier] += power[same, :, later]
            power[same, :, later] = 0.0
    return power, columns
