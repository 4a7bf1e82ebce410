"""Where image points lie on their splines: segment, t in [0, 1] within it, object coordinates.

X(t) = a0 + a1 t + a2 t² + a3 t³,   t = (u − u_start) / (u_end − u_start)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult


def places_on_splines(result: AdjustmentResult) -> tuple[IntArray, FloatArray, FloatArray]:
    """Segment (n,), t (n,) and object coordinates (n, 3), user frame, of all image points on splines."""
    curve, location = result.network.curve_observations.curve, result.curve_residuals.location
    columns = CurveColumns.of(result.curves)
    counts, segments = columns.segment_counts, columns.power_segments
    first = np.cumsum(counts) - counts
    segment = np.full(len(curve), -1, dtype=np.int64)
    t = np.full(len(curve), np.nan)
    xyz = np.full((len(curve), 3), np.nan)
    rows = np.flatnonzero(counts[curve] > 0)
    if len(rows):
        interval = segments.interval
        own, u = curve[rows], location[rows]
        index = _last_not_beyond(interval[:, 0], first[own], first[own] + counts[own] - 1, u)
        start, end = interval[index, 0], interval[index, 1]
        segment[rows], t[rows] = index - first[own], (u - start) / (end - start)
        powers = t[rows, None] ** np.arange(4)
        xyz[rows] = np.einsum("np,npc->nc", powers, segments.coefficients[index])
    for number in np.flatnonzero(counts == 0).tolist():  # no power form: the family's own functions
        rows = np.flatnonzero(curve == number)
        if len(rows):
            values = result.curves[number].values
            basis = basis_of(replace(result.network.curves[number], values=values))
            segment[rows], t[rows] = basis.locate(location[rows])
            xyz[rows] = basis.evaluate(location[rows], basis.coefficients_from_values(values))
    return segment, t, xyz


def _last_not_beyond(start: FloatArray, first: IntArray, last: IntArray, asked: FloatArray) -> IntArray:
    """Number of the last start from `first` to `last` that is not beyond what is asked for, else `first`, (n,).

    All are bisected together.
    """
    low, high = first.copy(), last.copy()
    while (low < high).any():
        middle = (low + high + 1) // 2
        reached = start[middle] <= asked
        low = np.where(reached, middle, low)
        high = np.where(reached, high, middle - 1)
    return low
