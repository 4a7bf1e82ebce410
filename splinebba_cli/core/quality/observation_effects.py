"""What errors of observations do to all unknowns: columns of the solution for errors of single equations.

An error e of whitened equation a (r = a d + ...) moves the unknowns by

    d = Q a' e,    N Q = 1,

with points eliminated: the reduced system takes a_r' - W_i H^-1 a_x', the point then H^-1 (a_x' - W' d_r).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.curve_chunks import equation_rows
from splinebba_cli.core.estimation.gauss_markov import Solution
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class EquationColumns:
    """Transposed equations a' as columns over the reduced unknowns and over the points."""

    reduced: FloatArray  # (N, q)
    point: FloatArray  # (n, 3, q)

    @classmethod
    def empty(cls, assembler: Assembler, count: int) -> EquationColumns:
        """Columns of zeros."""
        size = int(assembler.layout.node_starts[-1])
        return cls(np.zeros((size, count)), np.zeros((len(assembler.prepared.network.points.ids), 3, count)))


@dataclass(frozen=True)
class Effects:
    """Changes of the unknowns, one column an error."""

    orientation: FloatArray  # (m, 6, q) of (theta, X0)
    coefficients: FloatArray  # (C, 3, q)
    point: FloatArray  # (n, 3, q)


class ObservationEffects:
    """Solves for the effects of errors at a solution."""

    def __init__(self, assembler: Assembler, solution: Solution) -> None:
        if solution.factor is None or solution.eliminated is None:
            raise ValueError("no factor: the estimation did not converge")
        self.assembler, self.at = assembler, solution.linearization
        self.factor, self.eliminated = solution.factor, solution.eliminated

    def curve_rows(self, rows: IntArray) -> EquationColumns:
        """Equations of curve points, numbers in the rows of the linearisation."""
        layout, size = self.assembler.layout, self.assembler.orientation_size
        out = EquationColumns.empty(self.assembler, len(rows))
        chosen, jacobian = equation_rows(self.assembler, self.at, rows)
        columns = self.assembler.prepared.curves.columns[chosen.segment]
        place = (layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)).reshape(len(rows), -1)
        q = np.arange(len(rows))[:, None]
        np.add.at(out.reduced, (place, q), jacobian[:, size:])
        if size:
            own = 6 * chosen.image[:, None] + np.arange(6)
            np.add.at(out.reduced, (own, q), jacobian[:, :size])
        return out

    def image_points(self, rows: IntArray, axis: IntArray) -> EquationColumns:
        """Equations of coordinates (axis 0 or 1) of image points."""
        observed, layout = self.assembler.prepared.network.point_observations, self.assembler.layout
        out = EquationColumns.empty(self.assembler, len(rows))
        image, point, q = observed.image[rows], observed.point[rows], np.arange(len(rows))[:, None]
        a = self.at.points.orientation[rows, axis] * layout.image_mask[image]
        out.reduced[6 * image[:, None] + np.arange(6), q] = a
        x = self.at.points.object_xyz[rows, axis] * layout.point_mask[point]
        self._put(out, point, x)
        return out

    def orientation_priors(self, rows: IntArray, component: IntArray) -> EquationColumns:
        """Equations of prior orientations: rows of the linearisation and their component."""
        priors = self.at.orientation_priors
        out = EquationColumns.empty(self.assembler, len(rows))
        image, q = priors.image[rows], np.arange(len(rows))[:, None]
        a = priors.jacobian[rows, component] * self.assembler.layout.image_mask[image]
        out.reduced[6 * image[:, None] + np.arange(6), q] = a
        return out

    def point_priors(self, point: IntArray, axis: IntArray) -> EquationColumns:
        """Equations of control coordinates."""
        out = EquationColumns.empty(self.assembler, len(point))
        rows = np.zeros((len(point), 3))
        rows[np.arange(len(point)), axis] = self.assembler.point_inverse_sigma[point, axis]
        self._put(out, point, rows)
        return out

    def distances(self, rows: IntArray) -> EquationColumns:
        """Equations of distances."""
        kept, out = self.assembler.kept_points, EquationColumns.empty(self.assembler, len(rows))
        place = (kept.end_unknowns[rows], np.arange(len(rows))[:, None])
        np.add.at(out.reduced, place, kept.end_jacobian(self.at.distances)[rows])
        return out

    def _put(self, out: EquationColumns, point: IntArray, rows: FloatArray) -> None:
        """Rows (q, 3) over the coordinates of points into their places."""
        layout, q = self.assembler.layout, np.arange(len(point))
        kept = layout.node_of_point[point] >= 0
        out.reduced[layout.unknown_of_point[point[kept]], q[kept, None]] = rows[kept]
        out.point[point[~kept, None], np.arange(3), q[~kept, None]] = rows[~kept]

    def coefficient_rows(self, rows: IntArray) -> EquationColumns:
        """Equations of given values of curves."""
        layout, columns = self.assembler.layout, self.assembler.coefficient_rows.columns[rows]
        out = EquationColumns.empty(self.assembler, len(rows))
        place = (layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)).reshape(len(rows), -1)
        j = self.at.coefficient_jacobian[rows] * layout.coefficient_mask[columns][:, :, :]
        np.add.at(out.reduced, (place, np.arange(len(rows))[:, None]), j.reshape(len(rows), -1))
        return out

    def of(self, columns: EquationColumns, errors: FloatArray) -> Effects:
        """Effects of errors of equations.

        Parameters
        ----------
        columns : of q equations
        errors : (q,) whitened
        """
        layout, observed = self.assembler.layout, self.assembler.prepared.network.point_observations
        count = len(errors)
        side, at_point = columns.reduced * errors, columns.point * errors
        image_size = layout.image_mask.size
        # (n_obs, 6, 3) coupling; H^-1 a_x of every point first
        moved = np.einsum("nij,njq->niq", self.eliminated.inverse, at_point)
        if len(observed):
            reached = np.matmul(self.eliminated.coupling, moved[observed.point])
            images = side[:image_size].reshape(-1, 6, count)
            np.subtract.at(images, observed.image, reached)
            side[:image_size] = images.reshape(image_size, count)
        reduced = self.factor.solve(np.ascontiguousarray(side)) * self.assembler.mask[:, None]
        orientation = reduced[:image_size].reshape(-1, 6, count)
        if len(observed):
            back = np.matmul(self.eliminated.coupling.transpose(0, 2, 1), orientation[observed.image])
            np.subtract.at(at_point, observed.point, back)
            moved = np.einsum("nij,njq->niq", self.eliminated.inverse, at_point)
        point = moved * layout.eliminated_mask[:, :, None]
        kept = layout.kept_points
        point[kept] = reduced[layout.unknown_of_point[kept]]
        place = layout.unknown_of_coefficient[:, None] + np.arange(3)
        return Effects(orientation, reduced[place], point)
