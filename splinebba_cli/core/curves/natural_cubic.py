"""Natural cubic spline, open or closed, with corners: n + 1 (closed: n) coefficients of local support.

Every smooth piece is a clamped cubic B-spline whose second and last-but-one coefficients are eliminated by the
natural end conditions X'' = 0, so that the first and the last coefficient *are* the end knots and neighbouring
pieces share the corner.  One segment is a straight line.  A closed spline is a periodic B-spline.

Equivalent to Lee (3.4)-(3.11) with the corrected closed system; oracle: ``scipy.interpolate.CubicSpline``.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.network import Curve, FloatArray, IntArray


def natural_cubic(curve: Curve) -> CurveBasis:
    """Basis of a natural cubic spline given by its knots."""
    parameters = knot_parameters(curve.values, curve.parameterization, curve.closed, curve.knot_parameters)
    return natural_cubic_basis(parameters, curve.closed, curve.breaks)


def natural_cubic_basis(
    parameters: FloatArray, closed: bool = False, breaks: tuple[int, ...] = ()
) -> CurveBasis:
    """Basis of a natural cubic spline on given knot parameters.

    Parameters
    ----------
    parameters : (n + 1,) float, strictly ascending
    breaks : inner knots at which an open curve has a corner (C0)
    """
    segments = len(parameters) - 1
    if closed:
        if segments < 3:
            raise ValueError("a closed natural spline needs at least three knots")
        if breaks:
            raise ValueError("corners in a closed spline are not supported: open it at a corner")
        power, columns = _closed_tables(parameters)
        count = segments
    else:
        power, columns = _open_tables(parameters, breaks)
        count = segments + 1
    value_columns, value_weights = columns, power[:, 0, :]
    if not closed:
        value_columns = np.vstack([columns, columns[-1:]])
        value_weights = np.vstack([value_weights, power[-1].sum(axis=0)[None]])
    return CurveBasis(
        break_points=np.asarray(parameters, dtype=float),
        power=power,
        columns=columns,
        value_columns=value_columns,
        value_weights=value_weights,
        value_is_position=np.ones(count, dtype=bool),
        coefficient_count=count,
        closed=closed,
        has_location=True,
        anchors=parameters[:count],
    )


def _open_tables(parameters: FloatArray, breaks: tuple[int, ...]) -> tuple[FloatArray, IntArray]:
    segments = len(parameters) - 1
    power = np.zeros((segments, 4, 4))
    columns = np.zeros((segments, 4), dtype=np.int64)
    ends = [0, *sorted(breaks), segments]
    if any(not 0 < b < segments for b in breaks) or len(set(ends)) != len(ends):
        raise ValueError("corners must be distinct inner knots")
    for start, stop in pairwise(ends):
        piece_power, piece_columns = _natural_piece(parameters[start : stop + 1])
        power[start:stop] = piece_power
        columns[start:stop] = piece_columns + start
    return power, columns


def _natural_piece(parameters: FloatArray) -> tuple[FloatArray, IntArray]:
    """Tables of one smooth open piece; coefficients 0..n."""
    n = len(parameters) - 1
    if n == 1:
        power = np.zeros((1, 4, 4))
        power[0, 0, 0], power[0, 1, 0], power[0, 1, 1] = 1.0, -1.0, 1.0
        return power, np.array([[0, 1, 0, 0]])
    extended = np.concatenate([[parameters[0]] * 3, parameters, [parameters[-1]] * 3])
    power = bspline_power_tables(extended)
    full = np.arange(n)[:, None] + np.arange(4)  # B-spline coefficients b_0..b_{n+2}
    columns = np.clip(full - 1, 0, n)  # b_0 -> 0, b_j -> j - 1, b_{n+2} -> n (b_1, b_{n+1} see below)
    second_start = power[0, 2].copy()
    second_end = 2.0 * power[-1, 2] + 6.0 * power[-1, 3]
    _eliminate(power, columns, full, 1, (0, 2), second_start[:3], n)
    _eliminate(power, columns, full, n + 1, (n + 2, n), second_end[:0:-1], n)
    return power, columns


def _eliminate(
    power: FloatArray,
    columns: IntArray,
    full: IntArray,
    gone: int,
    kept: tuple[int, int],
    second: FloatArray,
    n: int,
) -> None:
    """Replace coefficient b_gone by its value from X'' = 0: second . (b_end, b_gone, b_inner) = 0."""
    end, inner = kept
    to_end, to_inner = -second[0] / second[1], -second[2] / second[1]
    end_column = 0 if end == 0 else n
    for segment in range(len(full)) if len(full) <= 4 else (0, 1, len(full) - 2, len(full) - 1):
        slots = np.flatnonzero(full[segment] == gone)
        if not len(slots):
            continue
        slot = slots[0]
        weight = power[segment, :, slot].copy()
        power[segment, :, np.flatnonzero(full[segment] == inner)[0]] += to_inner * weight
        holder = np.flatnonzero(full[segment] == end)
        if len(holder):
            power[segment, :, holder[0]] += to_end * weight
            power[segment, :, slot] = 0.0
        else:
            power[segment, :, slot] = to_end * weight
        columns[segment, slot] = end_column


def _closed_tables(parameters: FloatArray) -> tuple[FloatArray, IntArray]:
    n = len(parameters) - 1
    lengths = np.diff(parameters)
    period = parameters[-1] - parameters[0]
    turns = np.arange(-3, n + 4)
    extended = parameters[0] + (turns // n) * period + np.concatenate([[0.0], np.cumsum(lengths)])[turns % n]
    power = bspline_power_tables(extended)
    columns = (np.arange(n)[:, None] + np.arange(4)) % n
    if n == 3:  # the fourth coefficient is the first one again
        power[:, :, 0] += power[:, :, 3]
        power[:, :, 3] = 0.0
    return power, columns


def bspline_power_tables(extended: FloatArray) -> FloatArray:
    """Power form of the four cubic B-splines on every segment of an extended knot vector.

    de Boor's recursion on polynomials in t.  `extended` has three more knots at either end; segment s lies between
    extended[s + 3] and extended[s + 4].

    Returns
    -------
    (S, 4, 4) float : power of t, B-spline s + j
    """
    segments = len(extended) - 7
    left, right = extended[3 : 3 + segments], extended[4 : 4 + segments]
    length = right - left
    table = np.ones((segments, 1, 1))
    for degree in range(1, 4):
        new = np.zeros((segments, degree + 1, degree + 1))
        for j in range(degree):  # lower function j supports new functions j and j + 1
            low = extended[3 + j - degree + 1 : 3 + j - degree + 1 + segments]
            high = extended[4 + j : 4 + j + segments]
            span = high - low
            lower = table[:, :, j]
            falling_0, rising_0 = (high - left) / span, (left - low) / span
            slope = length / span
            new[:, :-1, j] += falling_0[:, None] * lower
            new[:, 1:, j] -= slope[:, None] * lower
            new[:, :-1, j + 1] += rising_0[:, None] * lower
            new[:, 1:, j + 1] += slope[:, None] * lower
        table = new
    return table
