"""The interface of all curve families: a basis times coefficients, X(u) = sum_j N_j(u) P_j.

On segment s, with t = (u - u_s) / (u_{s+1} - u_s),

    X(u) = sum_k e_k sum_j power[s, k, j] P[columns[s, j]]

e_k are elementary functions: the powers 1, t, t^2, t^3, or 1, cos u, sin u, cos 2u, sin 2u, ... of the global u.
A family is a function that builds the :class:`CurveBasis` of one curve; everything else (evaluation, elimination,
dispersion, gauge, reports) works on the tables.  ``values`` are what people give and read (knots of a spline, end
points of a line, a0..a3 of every segment): they are a linear map of the coefficients, given row by row, and may be
more than these where continuity ties them together.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

MAX_POWER = 4  # powers 1, t, t^2, t^3


@dataclass(frozen=True)
class CurveBasis:
    """Basis of one curve as tables of elementary functions with local support."""

    break_points: FloatArray  # (S + 1,) knot parameters, ascending
    power: FloatArray  # (S, 4, w): power of t, slot of the support; trigonometric: (S, 2 m + 1, w)
    columns: IntArray  # (S, w) coefficient of every slot (unused slots repeat a column with weight 0)
    value_columns: IntArray  # (k, w) coefficients in each row of `values`
    value_weights: FloatArray  # (k, w) their weights
    value_is_position: BoolArray  # (k,) row of `values` is a position (False: a vector such as a1)
    coefficient_count: int
    closed: bool
    has_location: bool  # False: the curve is a single point
    anchors: FloatArray  # (g,) parameters of the gauge conditions
    loose_anchors: BoolArray = field(
        default_factory=lambda: np.zeros(0, dtype=bool)
    )  # (g,) or none: decision 7
    trigonometric: bool = False  # elementary functions 1, cos u, sin u, ... instead of powers of t
    shape_forms: FloatArray = field(
        default_factory=lambda: np.zeros((0, 0, 0))
    )  # (f, m, m), see shape_forms.py

    @property
    def segment_count(self) -> int:
        """Number of segments."""
        return len(self.power)

    @property
    def support(self) -> int:
        """Number of coefficients that one u touches."""
        return int(self.power.shape[2])

    def coefficients_from_values(self, values: FloatArray) -> FloatArray:
        """Coefficients (m, 3) of the user's values (k, 3), by least squares where k exceeds m."""
        if self.value_weights.shape[1] == 1 and np.array_equal(
            self.value_columns[:, 0], np.arange(self.coefficient_count)
        ):
            return values.copy()
        return _solve_rows(self.value_columns, self.value_weights, values, self.coefficient_count)

    def pure_values(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Rows of the values that are one coefficient times a number: rows, coefficients, numbers, (p,) each."""
        used = np.abs(self.value_weights) > 0.0
        rows = np.flatnonzero(used.sum(axis=1) == 1)
        slot = np.argmax(used[rows], axis=1)
        return rows, self.value_columns[rows, slot], self.value_weights[rows, slot]

    def values_from_coefficients(self, coefficients: FloatArray) -> FloatArray:
        """The user's values (k, 3) of coefficients (m, 3)."""
        return np.asarray(np.einsum("kw,kwd->kd", self.value_weights, coefficients[self.value_columns]))

    def locate(self, u: ArrayLike) -> tuple[IntArray, FloatArray]:
        """Segment and t of locations; closed curves wrap, open ones extend their end segments."""
        wrapped = np.asarray(u, dtype=float)
        first, last = self.break_points[0], self.break_points[-1]
        if self.closed:
            wrapped = first + np.mod(wrapped - first, last - first)
        segment = np.searchsorted(self.break_points, wrapped, side="right") - 1
        segment = np.clip(segment, 0, self.segment_count - 1)
        length = self.break_points[segment + 1] - self.break_points[segment]
        return segment, (wrapped - self.break_points[segment]) / length

    def evaluate(self, u: ArrayLike, coefficients: FloatArray, order: int = 0) -> FloatArray:
        """The curve (order 0) or its derivative d/du of the given order at u, (n, 3)."""
        segment, t = self.locate(u)
        length = self.break_points[segment + 1] - self.break_points[segment]
        if self.trigonometric:
            row = harmonic_row(self.break_points[segment] + t * length, order, self.power.shape[1])
        else:
            row = power_row(t, order) / length[:, None] ** order
        weights = np.einsum("nk,nkw->nw", row, self.power[segment])
        return np.asarray(np.einsum("nw,nwd->nd", weights, coefficients[self.columns[segment]]))


def power_row(t: FloatArray, order: int = 0) -> FloatArray:
    """Powers 1, t, t^2, t^3 differentiated `order` times with respect to t, (n, 4)."""
    row = np.zeros((len(t), MAX_POWER), dtype=np.asarray(t).dtype)
    for k in range(order, MAX_POWER):
        factor = 1.0
        for i in range(order):
            factor *= k - i
        row[:, k] = factor * t ** (k - order)
    return row


def harmonic_row(u: FloatArray, order: int, count: int) -> FloatArray:
    """1, cos u, sin u, cos 2u, sin 2u, ... differentiated `order` times with respect to u, (n, count)."""
    row = np.zeros((len(u), count), dtype=np.asarray(u).dtype)
    row[:, 0] = 1.0 if order == 0 else 0.0
    k = np.arange(1, (count - 1) // 2 + 1)
    phase = np.asarray(u)[:, None] * k
    cosine, sine = np.cos(phase), np.sin(phase)
    cycle = ((cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine))[order % 4]
    row[:, 1::2], row[:, 2::2] = (k.astype(float) ** order * part for part in cycle)
    return row


def _solve_rows(columns: IntArray, weights: FloatArray, values: FloatArray, count: int) -> FloatArray:
    """Solve the row system that maps `count` coefficients to values; least squares where there are more rows."""
    rows = len(values)
    if rows <= 64:
        matrix = np.zeros((rows, count))
        np.add.at(matrix, (np.arange(rows)[:, None], columns), weights)
        solved = np.linalg.solve if rows == count else _least_squares
        return np.asarray(solved(matrix, values), dtype=float)
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    number = np.repeat(np.arange(rows), columns.shape[1])
    sparse = coo_matrix((weights.ravel(), (number, columns.ravel())), shape=(rows, count)).tocsc()
    if rows == count:
        return np.asarray(splu(sparse).solve(np.ascontiguousarray(values)))
    normal = splu((sparse.T @ sparse).tocsc())
    found = np.asarray(normal.solve(np.ascontiguousarray(sparse.T @ values)))
    again = np.asarray(normal.solve(np.ascontiguousarray(sparse.T @ (values - sparse @ found))))
    return np.asarray(found + again, dtype=float)


def _least_squares(matrix: FloatArray, values: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.lstsq(matrix, values, rcond=None)[0], dtype=float)


def knot_parameters(
    knots: FloatArray, parameterization: str, closed: bool, given: FloatArray | None = None
) -> FloatArray:
    """Knot parameters: given, one unit per segment, or the cumulated chord length.

    Parameters
    ----------
    knots : (k, 3) float, metres

    Returns
    -------
    (k,) float for an open curve, (k + 1,) for a closed one

    Raises
    ------
    ValueError
        If parameters are not strictly ascending (coinciding knots).
    """
    segments = len(knots) if closed else len(knots) - 1
    if given is not None:
        parameters = np.asarray(given, dtype=float)
    elif parameterization == "uniform":
        parameters = np.arange(segments + 1, dtype=float)
    else:
        following = np.vstack([knots[1:], knots[:1]]) if closed else knots[1:]
        chords = np.linalg.norm(following - knots[: len(following)], axis=1)
        parameters = np.concatenate([[0.0], np.cumsum(chords)])
    if len(parameters) != segments + 1:
        raise ValueError(f"{segments + 1} knot parameters are needed, not {len(parameters)}")
    if not np.all(np.diff(parameters) > 0.0):
        raise ValueError("knot parameters must ascend strictly: two knots coincide")
    return parameters
