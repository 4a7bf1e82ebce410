"""Natural cubic spline, open or closed, with corners: n + 1 (closed: n) coefficients of local support.

Every smooth piece is a clamped cubic B-spline whose second and last-but-one coefficients are eliminated by the
natural end conditions X'' = 0, so that the first and the last coefficient *are* the end knots and neighbouring
pieces share the corner.  One segment is a straight line.  A closed spline is a periodic B-spline.

Equivalent to Lee (3.4)-(3.11) with the corrected closed system; oracle: ``scipy.interpolate.CubicSpline``.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, knot_parameters
from splinebba_cli.core.curves.bspline_tables import bspline_power_tables, clamped, periodic_tables
from splinebba_cli.core.network import Curve, FloatArray, IntArray

SHARED_BASES = 2**15  # that are kept: networks with the same curves are made again and again


def natural_cubic(curve: Curve) -> CurveBasis:
    """Basis of a natural cubic spline given by its knots."""
    parameters = knot_parameters(curve.values, curve.parameterization, curve.closed, curve.knot_parameters)
    return _basis_of_bytes(parameters.tobytes(), curve.closed, curve.breaks)


@lru_cache(maxsize=SHARED_BASES)
def _basis_of_bytes(parameters: bytes, closed: bool, breaks: tuple[int, ...]) -> CurveBasis:
    """Many curves share their knot parameters, uniform ones for example."""
    return natural_cubic_basis(np.frombuffer(parameters), closed, breaks)


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
        power, columns = periodic_tables(np.asarray(parameters, dtype=float))
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
    power, full = bspline_power_tables(clamped(parameters, 3))  # B-spline coefficients b_0..b_{n+2}
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
