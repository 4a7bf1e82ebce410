"""The whitened equations of a solution as sparse rows: across the curves, image points, priors and control.

Row order: curve points (across, then along for held locations), image points of points (x and y in turn), distances,
orientation priors, control coordinates, equations over coefficients.  Arc lengths, tangents and the equations along
linked chains are not among them: their part of the information is in the factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy import sparse

from splinebba_cli.core.estimation.curve_chunks import CurveEquations
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.threads import in_threads

ORIENTATION = np.arange(6)
WORTH_THREADS = 20_000
"""Rows from which products with them are worth two threads."""


@dataclass(frozen=True)
class RowRanges:
    """Where the rows of each kind begin."""

    curve: int  # 0
    points: int
    distances: int
    priors: int
    control: int
    coefficients: int
    count: int


@dataclass(frozen=True)
class SparseDesign:
    """Rows A = [A_r A_x] over the reduced unknowns and the object points; removed unknowns have zero columns."""

    ranges: RowRanges
    reduced: sparse.csr_array  # (rows, N)
    points: sparse.csr_array  # (rows, 3 n)
    residual: FloatArray  # (rows,) whitened, adjusted - measured
    curve: CurveEquations  # of the rows of curve points

    @cached_property
    def _parts(self) -> list[tuple[slice, sparse.csr_array]]:
        """The reduced rows in two parts for two threads; few rows in one."""
        matrix, count = self.reduced, self.ranges.count
        bounds = [0, count // 2, count] if count >= WORTH_THREADS else [0, count]
        parts = []
        for begin, end in pairwise(bounds):
            own = slice(int(matrix.indptr[begin]), int(matrix.indptr[end]))
            entries = (matrix.data[own], matrix.indices[own], matrix.indptr[begin : end + 1] - own.start)
            rows = sparse.csr_array(entries, shape=(end - begin, matrix.shape[1]))
            parts.append((slice(begin, end), rows))
        return parts

    def over_unknowns(self, errors: FloatArray) -> FloatArray:
        """A_r'E of errors (rows, k), (N, k)."""
        sums = in_threads(lambda part: np.asarray(part[1].T @ errors[part[0]]), self._parts)
        return np.asarray(sum(sums[1:], start=sums[0]))

    def on_rows(self, step: FloatArray) -> FloatArray:
        """A_r D of changes of the unknowns (N, k), (rows, k)."""
        return np.concatenate(in_threads(lambda part: np.asarray(part[1] @ step), self._parts))

    @cached_property
    def coupling(self) -> sparse.csr_array:
        """A_r'A_x, (N, 3 n)."""
        return sparse.csr_array(self.reduced.T @ self.points)


def sparse_design(assembler: Assembler, at: Linearization, curve: CurveEquations) -> SparseDesign:
    """All rows at one state, of which those of the curve points are at hand."""
    priors, weight = at.orientation_priors, assembler.point_inverse_sigma
    parts = [
        len(curve.point),
        2 * len(at.points.residual),
        len(at.distances.residual),
        int(priors.active.sum()),
        int((weight > 0.0).sum()),
    ]
    begin = np.cumsum([0, *parts, len(assembler.coefficient_rows)])
    ranges = RowRanges(*(int(n) for n in begin))
    on_points = _on_points(assembler, at, ranges)
    entries = [
        _point_entries(assembler, at, ranges.points),
        _distance_entries(assembler, at, ranges.distances),
        _kept_entries(assembler, on_points),
        _prior_entries(at, ranges.priors),
        _coefficient_entries(assembler, at, ranges.coefficients),
    ]
    others = _matrix(entries, (ranges.count, int(assembler.layout.node_starts[-1])), assembler.mask)
    reduced = _with_curve_rows(assembler, curve, others)
    residual = np.concatenate(
        [
            curve.residual,
            at.points.residual.ravel(),
            at.distances.residual,
            priors.residual[priors.active],
            at.point_prior_residual[weight > 0.0],
            at.coefficient_residual,
        ]
    )
    mask = assembler.layout.eliminated_mask
    points = _matrix(on_points, (ranges.count, mask.size), mask.ravel())
    return SparseDesign(ranges, reduced, points, residual, curve)


def _with_curve_rows(
    assembler: Assembler, curve: CurveEquations, others: sparse.csr_array
) -> sparse.csr_array:
    """All rows: those of the curve points before the others."""
    layout, size, curves = assembler.layout, assembler.orientation_size, assembler.prepared.curves
    rows, width = curve.jacobian.shape
    own = rows * width
    index = np.int32 if max(own + others.nnz, others.shape[1]) < np.iinfo(np.int32).max else np.int64
    indices = np.empty(own + others.nnz, dtype=index)
    columns = indices[:own].reshape(rows, width)
    image = assembler.prepared.network.curve_observations.image[curve.point].astype(index)
    columns[:, :size] = 6 * image[:, None] + ORIENTATION[:size].astype(index)
    unknown = (layout.unknown_of_coefficient[curves.columns][:, :, None] + np.arange(3)).astype(index)
    columns[:, size:] = unknown.reshape(len(unknown), width - size)[curve.segment]
    indices[own:] = others.indices
    data = curve.entries[: own + others.nnz]  # the Jacobian is not copied
    data[own:] = others.data
    pointer = np.concatenate([np.arange(rows) * width, own + others.indptr[rows:]]).astype(index)
    return sparse.csr_array((data, indices, pointer), shape=others.shape)


Entries = tuple[IntArray, IntArray, FloatArray]  # row, column, value of the same shape


def _matrix(entries: list[Entries], shape: tuple[int, int], mask: FloatArray) -> sparse.csr_array:
    row, column, value = (np.concatenate([part[i].ravel() for part in entries]) for i in range(3))
    value = value * mask[column]
    return sparse.coo_array((value, (row, column)), shape=shape).tocsr()


def _spread(rows: IntArray, columns: IntArray, values: FloatArray) -> Entries:
    return np.broadcast_to(rows[:, None], values.shape), np.broadcast_to(columns, values.shape), values


def _point_entries(assembler: Assembler, at: Linearization, first: int) -> Entries:
    image = assembler.prepared.network.point_observations.image.repeat(2)
    rows = first + np.arange(len(image))
    return _spread(rows, 6 * image[:, None] + ORIENTATION, at.points.orientation.reshape(-1, 6))


def _prior_entries(at: Linearization, first: int) -> Entries:
    q, c = np.nonzero(at.orientation_priors.active)
    columns = 6 * at.orientation_priors.image[q][:, None] + ORIENTATION
    return _spread(first + np.arange(len(q)), columns, at.orientation_priors.jacobian[q, c])


def _coefficient_entries(assembler: Assembler, at: Linearization, first: int) -> Entries:
    rows = assembler.coefficient_rows
    unknown = assembler.layout.unknown_of_coefficient[rows.columns]
    shape = (len(rows), 3 * rows.columns.shape[1])
    columns = (unknown[:, :, None] + np.arange(3)).reshape(shape)
    return _spread(first + np.arange(len(rows)), columns, at.coefficient_jacobian.reshape(shape))


def _distance_entries(assembler: Assembler, at: Linearization, first: int) -> Entries:
    kept = assembler.kept_points
    rows = first + np.arange(len(kept.end_unknowns))
    return _spread(rows, kept.end_unknowns, kept.end_jacobian(at.distances))


def _on_points(assembler: Assembler, at: Linearization, ranges: RowRanges) -> list[Entries]:
    """Entries over the coordinates of all points, 3 a point."""
    point = assembler.prepared.network.point_observations.point.repeat(2)
    seen = _spread(
        ranges.points + np.arange(len(point)),
        3 * point[:, None] + np.arange(3),
        at.points.object_xyz.reshape(-1, 3),
    )
    n, d = np.nonzero(assembler.point_inverse_sigma > 0.0)
    given = (ranges.control + np.arange(len(n)), 3 * n + d, assembler.point_inverse_sigma[n, d])
    return [seen, given]


def _kept_entries(assembler: Assembler, on_points: list[Entries]) -> Entries:
    """Those of the points that stay in the reduced system, over its unknowns."""
    row, column, value = (np.concatenate([part[i].ravel() for part in on_points]) for i in range(3))
    kept = assembler.layout.node_of_point[column // 3] >= 0
    return row[kept], assembler.layout.unknown_of_point.ravel()[column[kept]], value[kept]
