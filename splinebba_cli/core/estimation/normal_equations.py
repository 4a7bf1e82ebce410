"""Linearised network and its reduced normal equations N d = h over cameras and curve coefficients.

h = -A'Pr,   N = A'PA   with locations and points eliminated (theory, sections 3 and 7)
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor, analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.elimination import (
    EliminatedPoints,
    PointPairs,
    eliminate_points,
)
from splinebba_cli.core.estimation.kept_points import KeptPoints, kept_pairs
from splinebba_cli.core.estimation.linked_windows import LinkedWindows, linked_pairs
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout, node_positions
from splinebba_cli.core.estimation.window_map import Slot, WindowMap, pair_map
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows
from splinebba_cli.core.observations.curve_points import CurveRows, linearize_curve_points
from splinebba_cli.core.observations.distances import DistanceRows, linearize_distances
from splinebba_cli.core.observations.image_points import PointRows, linearize_image_points
from splinebba_cli.core.observations.linked_points import LinkedEquations, linearize_linked_points
from splinebba_cli.core.observations.orientation_priors import PriorRows, linearize_orientation_priors
from splinebba_cli.core.observations.second_order_rows import second_order_rows
from splinebba_cli.core.row_groups import RowGroups
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class CurveWindows:
    """Rows of curve points grouped by image and segment."""

    groups: RowGroups
    image: IntArray  # (G,)
    segment: IntArray  # (G,)
    window: WindowMap


@dataclass(frozen=True)
class Linearization:
    """All equations at one state."""

    state: State
    curve: CurveRows
    curve_jacobian: FloatArray  # (k, 6 or 0 + 3 w + 1) masked, the residual last
    windows: CurveWindows
    linked: LinkedEquations
    linked_windows: tuple[LinkedWindows, ...]
    held: IntArray  # measured curve points whose location is no unknown, or no foot point yet
    points: PointRows
    distances: DistanceRows
    orientation_priors: PriorRows
    point_prior_residual: FloatArray  # (n, 3) whitened
    coefficient_residual: FloatArray  # (q,) whitened, values and conditions
    coefficient_jacobian: FloatArray  # (q, w, 3) of the same, at the state
    cost: float
    base_values: FloatArray  # flat, before points are eliminated, removed unknowns with unit diagonal
    base_side: FloatArray  # (N,)


class Assembler:
    """Builds normal equations for one layout; keeps pattern, ordering and index maps between iterations."""

    def __init__(
        self, prepared: Prepared, layout: ParameterLayout, coefficient_rows: CoefficientRows
    ) -> None:
        self.prepared = prepared
        self.layout = layout
        self.coefficient_rows = coefficient_rows
        # with all orientations held the curves fall apart into blocks of their own
        self.orientation_size = ORIENTATION_SIZE if layout.image_mask.any() else 0
        observed = prepared.network.point_observations
        self.pairs = PointPairs.of(observed.point, observed.image)
        sigma = prepared.network.points.sigma
        weighted = np.isfinite(sigma) & (sigma > 0.0)
        self.point_inverse_sigma = np.where(weighted, 1.0 / np.where(weighted, sigma, 1.0), 0.0)
        self._kept_points: KeptPoints | None = None
        self._structure: BlockStructure | None = None
        self._symbolic: SymbolicFactor | None = None
        self._windows: CurveWindows | None = None
        self._windows_of: IntArray = np.zeros(0, dtype=np.int64)
        self._pair_map: WindowMap | None = None
        self._row_map: WindowMap | None = None

    def with_weights(self, prepared: Prepared) -> Assembler:
        """The same measurements with other weights: pattern and ordering stay."""
        other = copy.copy(self)
        other.prepared = prepared
        return other

    @cached_property
    def mask(self) -> FloatArray:
        """Mask of the reduced unknowns, (N,)."""
        return self.layout.reduced_mask()

    @property
    def structure(self) -> BlockStructure:
        """Pattern of the reduced normal matrix."""
        if self._structure is None:
            raise RuntimeError("linearize first")
        return self._structure

    @property
    def kept_points(self) -> KeptPoints:
        """Points that stay in the reduced system, and the distances between stations."""
        if self._kept_points is None:
            self._kept_points = KeptPoints.of(self.prepared.network, self.layout, self.structure)
        return self._kept_points

    def linearize(self, state: State, held: IntArray) -> Linearization:
        """Equations and normal equations (points not yet eliminated) at a state.

        Raises
        ------
        FloatingPointError
            If something measured lies behind a camera.
        """
        network, layout = self.prepared.network, self.layout
        curve = linearize_curve_points(self.prepared, state, held)
        points = linearize_image_points(self.prepared, state)
        distances = linearize_distances(network.distances, state)
        priors = linearize_orientation_priors(network.images, state)
        point_prior = np.where(
            self.point_inverse_sigma > 0.0, (state.xyz - network.points.xyz) * self.point_inverse_sigma, 0.0
        )
        coefficient = self.coefficient_rows.residual(state.coefficients)
        coefficient_jacobian = self.coefficient_rows.jacobian_at(state.coefficients)
        linked = linearize_linked_points(self.prepared, state, held)
        windows, linked_windows = self._windows_at(curve, linked)
        columns = self.prepared.curves.columns[curve.segment]
        local = curve.weights[:, :, None] * curve.direction[:, None, :] * layout.coefficient_mask[columns]
        jacobian = np.concatenate(
            [
                (curve.orientation * layout.image_mask[curve.image])[:, : self.orientation_size],
                local.reshape(len(local), 3 * local.shape[1]),
                curve.residual[:, None],
            ],
            axis=1,
        )
        values, side = self._base(jacobian, windows, points, priors, coefficient, coefficient_jacobian)
        self.kept_points.add(values, side, points, distances, self.point_inverse_sigma, point_prior)
        for window in linked_windows:
            window.add(values, side)
        self._unit_diagonal(values)
        cost = (
            curve.cost + linked.cost + points.cost + distances.cost + priors.cost
            + float(np.sum(point_prior**2) + coefficient @ coefficient)
        )  # fmt: skip
        linked_held = held[self.prepared.chains.linked[held]]
        all_held = np.concatenate([curve.point[len(curve.speed) :], linked_held])
        return Linearization(
            state, curve, jacobian, windows, linked, linked_windows, all_held, points, distances, priors, point_prior,
            coefficient, coefficient_jacobian, cost, values, side,
        )  # fmt: skip

    def eliminate(self, at: Linearization, damping: float) -> tuple[FloatArray, FloatArray, EliminatedPoints]:
        """Flat values and right-hand side of the reduced system, points eliminated, diagonal times 1 + damping."""
        values, side = at.base_values.copy(), at.base_side.copy()
        if damping > 0.0:
            self._scale_diagonal(values, 1.0 + damping)
        observed = self.prepared.network.point_observations
        orientation = at.points.orientation * self.layout.image_mask[observed.image][:, None, :]
        eliminated = eliminate_points(
            orientation, at.points.object_xyz, at.points.residual, observed.point,
            self.point_inverse_sigma**2, -self.point_inverse_sigma * at.point_prior_residual,
            self.layout.eliminated_mask, damping,
        )  # fmt: skip
        if len(observed) and self._pair_map is not None:
            gain = np.matmul(eliminated.coupling, eliminated.inverse[observed.point])
            a, b = self.pairs.a, self.pairs.b
            self._pair_map.add(values, -np.matmul(gain[a], eliminated.coupling[b].transpose(0, 2, 1)))
            image_side = side[: self.layout.image_mask.size].reshape(-1, ORIENTATION_SIZE)
            np.subtract.at(
                image_side,
                observed.image,
                np.matmul(gain, eliminated.right_side[observed.point][:, :, None])[:, :, 0],
            )
        return values, side, eliminated

    def stiffness(self, at: Linearization) -> FloatArray:
        """Flat values that the second-order part of the locations adds to the normal matrix."""
        rows, layout = second_order_rows(self.prepared, at.state), self.layout
        values = np.zeros(len(at.base_values))
        if not len(rows.point):
            return values
        columns = self.prepared.curves.columns[rows.segment]
        local = rows.weights[:, :, None] * rows.direction[:, None, :] * layout.coefficient_mask[columns]
        orientation = (rows.orientation * layout.image_mask[rows.image])[:, : self.orientation_size]
        jacobian = np.concatenate([orientation, local.reshape(len(local), 3 * local.shape[1])], axis=1)
        window = WindowMap.of(self.structure, self._slots(rows.image, rows.segment))
        window.add(values, jacobian[:, :, None] * jacobian[:, None, :])
        return values

    def symbolic(self, state: State) -> SymbolicFactor:
        """Ordering and symbolic factor of the current pattern."""
        if self._symbolic is None:
            self._symbolic = analyse(self.structure, node_positions(self.layout, state))
        return self._symbolic

    def slots_of_columns(self, columns: IntArray) -> list[Slot]:
        """Slots of the coefficients under windows, (G, w)."""
        layout = self.layout
        return [
            Slot(layout.node_of_coefficient[columns[:, j]], layout.slot_of_coefficient[columns[:, j]], 3)
            for j in range(columns.shape[1])
        ]

    def row_window(self) -> WindowMap:
        """Positions of the windows of the coefficient rows."""
        if self._row_map is None:
            self._row_map = WindowMap.of(self.structure, self.slots_of_columns(self.coefficient_rows.columns))
        return self._row_map

    def pair_window(self) -> WindowMap | None:
        """Positions of the 6 x 6 blocks of the point pairs (None without points)."""
        return self._pair_map

    def _scale_diagonal(self, values: FloatArray, factor: float) -> None:
        structure = self.structure
        diagonal = structure.find(np.arange(len(structure.sizes)), np.arange(len(structure.sizes)))
        for size in np.unique(structure.sizes):
            nodes = np.flatnonzero(structure.sizes == size)
            place = structure.offsets[diagonal[nodes]][:, None] + np.arange(size) * (size + 1)
            values[place] *= factor

    def _base(
        self,
        jacobian: FloatArray,
        windows: CurveWindows,
        points: PointRows,
        priors: PriorRows,
        coefficient: FloatArray,
        coefficient_jacobian: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        structure, layout = self.structure, self.layout
        values, side = np.zeros(int(structure.offsets[-1])), np.zeros(int(layout.node_starts[-1]))
        image_side = side[: layout.image_mask.size].reshape(-1, ORIENTATION_SIZE)
        unknown = layout.unknown_of_coefficient
        if len(jacobian):
            gram = windows.groups.gram(jacobian)
            windows.window.add(values, gram[:, :-1, :-1])
            if self.orientation_size:
                np.subtract.at(image_side, windows.image, gram[:, : self.orientation_size, -1])
            place = unknown[self.prepared.curves.columns[windows.segment]][:, :, None] + np.arange(3)
            np.subtract.at(side, place.reshape(len(place), -1), gram[:, self.orientation_size : -1, -1])
        image_blocks = np.zeros((layout.image_count, 6, 6))
        observed = self.prepared.network.point_observations
        if len(observed):
            a = points.orientation * layout.image_mask[observed.image][:, None, :]
            np.add.at(image_blocks, observed.image, np.matmul(a.transpose(0, 2, 1), a))
            np.subtract.at(
                image_side,
                observed.image,
                np.matmul(a.transpose(0, 2, 1), points.residual[:, :, None])[:, :, 0],
            )
        if len(priors.image):
            p = priors.jacobian * layout.image_mask[priors.image][:, None, :]
            np.add.at(image_blocks, priors.image, np.matmul(p.transpose(0, 2, 1), p))
            np.subtract.at(
                image_side,
                priors.image,
                np.matmul(p.transpose(0, 2, 1), priors.residual[:, :, None])[:, :, 0],
            )
        images = np.arange(layout.image_count)
        place = structure.offsets[structure.find(images, images)][:, None] + np.arange(36)
        values[place] += image_blocks.reshape(-1, 36)
        rows = self.coefficient_rows
        if len(rows):
            j = (coefficient_jacobian * layout.coefficient_mask[rows.columns]).reshape(len(rows), -1)
            self.row_window().add(values, j[:, :, None] * j[:, None, :])
            place = (unknown[rows.columns][:, :, None] + np.arange(3)).reshape(len(rows), -1)
            np.subtract.at(side, place, j * coefficient[:, None])
        return values, side

    def _unit_diagonal(self, values: FloatArray) -> None:
        removed = np.flatnonzero(self.mask == 0.0)
        node = np.searchsorted(self.layout.node_starts, removed, side="right") - 1
        local = removed - self.layout.node_starts[node]
        structure = self.structure
        values[structure.offsets[structure.find(node, node)] + local * (structure.sizes[node] + 1)] = 1.0

    def _windows_at(
        self, curve: CurveRows, linked: LinkedEquations
    ) -> tuple[CurveWindows, tuple[LinkedWindows, ...]]:
        """Windows of the current segments and chains; the pattern grows when a location reaches a new segment."""
        keys = curve.image * int(self.prepared.curves.segment_start[-1] + 1) + curve.segment
        if self._windows is None or not np.array_equal(keys, self._windows_of):
            groups = RowGroups.of(keys)
        else:
            groups = self._windows.groups
        image, segment = curve.image[groups.representative], curve.segment[groups.representative]
        if self._structure is None:
            self._rebuild(image, segment, linked)
        for _ in range(2):
            try:
                windows = self._curve_windows(groups, image, segment, keys)
                return windows, tuple(
                    LinkedWindows.of(batch, self.layout, self.structure, self.orientation_size)
                    for batch in linked.batches
                )
            except KeyError:
                self._rebuild(image, segment, linked)
        raise RuntimeError("a pair of nodes is missing in a pattern that was made for it")

    def _curve_windows(
        self, groups: RowGroups, image: IntArray, segment: IntArray, keys: IntArray
    ) -> CurveWindows:
        """Windows of the current segments, the last ones where nothing has changed."""
        if self._windows is None or groups is not self._windows.groups:
            window = WindowMap.of(self.structure, self._slots(image, segment))
            self._windows, self._windows_of = CurveWindows(groups, image, segment, window), keys
        return self._windows

    def _slots(self, image: IntArray, segment: IntArray) -> list[Slot]:
        """Slots of windows of an image and a segment."""
        slots = [Slot(image, np.zeros_like(image), ORIENTATION_SIZE)] if self.orientation_size else []
        return slots + self.slots_of_columns(self.prepared.curves.columns[segment])

    def _rebuild(self, image: IntArray, segment: IntArray, linked: LinkedEquations) -> None:
        layout, curves = self.layout, self.prepared.curves
        node = layout.node_of_coefficient
        rows, columns = [], []
        if self._structure is not None:
            rows.append(self._structure.rows)
            columns.append(self._structure.cols)
        for table in (curves.columns, self.coefficient_rows.columns):
            for i in range(table.shape[1]):
                for j in range(i):
                    rows.append(node[table[:, i]])
                    columns.append(node[table[:, j]])
        for step in (
            (-1, 0, 1) if self.orientation_size else ()
        ):  # a location may reach the next segment without a new ordering
            near = np.clip(segment + step, 0, max(len(curves.left) - 1, 0))
            start = np.searchsorted(curves.segment_start, segment, side="right") - 1
            same = np.searchsorted(curves.segment_start, near, side="right") - 1 == start
            for j in range(curves.support):
                rows.append(image[same])
                columns.append(node[curves.columns[near[same], j]])
        for batch in linked.batches:
            first, second = linked_pairs(batch, layout, self.orientation_size)
            rows.append(first)
            columns.append(second)
        observed = self.prepared.network.point_observations
        rows.append(observed.image[self.pairs.a])
        columns.append(observed.image[self.pairs.b])
        for first, second in kept_pairs(self.prepared.network, layout):
            rows.append(first)
            columns.append(second)
        self._structure = BlockStructure.from_pairs(
            layout.node_sizes, np.concatenate(rows), np.concatenate(columns)
        )
        self._symbolic, self._row_map, self._windows, self._kept_points = None, None, None, None
        if len(observed):
            a, b = observed.image[self.pairs.a], observed.image[self.pairs.b]
            zero = np.zeros_like(a)
            self._pair_map = pair_map(self._structure, Slot(a, zero, 6), Slot(b, zero, 6))
