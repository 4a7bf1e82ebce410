"""Linearised network and its reduced normal equations N d = h over cameras and curve coefficients.

h = -A'Pr,   N = A'PA   with locations and points eliminated (theory, sections 3 and 7)
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor, analyse
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.coefficient_normals import CoefficientNormals
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_normals import CurveNormals
from splinebba_cli.core.estimation.curve_windows import CurveWindows
from splinebba_cli.core.estimation.elimination import (
    EliminatedPoints,
    PointPairs,
    eliminate_points,
)
from splinebba_cli.core.estimation.factor_memory import require_memory
from splinebba_cli.core.estimation.image_normals import add_images
from splinebba_cli.core.estimation.kept_points import KeptPoints
from splinebba_cli.core.estimation.linked_windows import LinkedWindows
from splinebba_cli.core.estimation.located_points import Located, ResidualsOnCurves
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout, node_positions
from splinebba_cli.core.estimation.pattern import pattern_of
from splinebba_cli.core.estimation.segment_windows import (
    SegmentWindows,
    add_segment_windows,
    coefficient_slots,
    masked_jacobian,
)
from splinebba_cli.core.estimation.window_map import Slot, WindowMap, pair_map
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows
from splinebba_cli.core.observations.curve_points import CurveRows, linearize_curve_points
from splinebba_cli.core.observations.distances import DistanceRows, linearize_distances
from splinebba_cli.core.observations.image_points import PointRows, linearize_image_points
from splinebba_cli.core.observations.linked_points import LinkedEquations, linearize_linked_points
from splinebba_cli.core.observations.orientation_priors import PriorRows, linearize_orientation_priors
from splinebba_cli.core.observations.second_order_rows import second_order_rows
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class Linearization:
    """All equations at one state; the rows of single curve points only when they are asked for."""

    state: State
    held_locations: IntArray  # measured curve points whose location is held
    on_curves: ResidualsOnCurves
    linked: LinkedEquations
    linked_windows: tuple[LinkedWindows, ...]
    points: PointRows
    distances: DistanceRows
    orientation_priors: PriorRows
    point_prior_residual: FloatArray  # (n, 3) whitened
    coefficient_residual: FloatArray  # (q,) whitened, values and conditions
    coefficient_jacobian: FloatArray  # (q, w, 3) of the same, at the state
    cost: float
    base_values: FloatArray  # flat, before points are eliminated, removed unknowns with unit diagonal
    base_side: FloatArray  # (N,)
    structure: BlockStructure  # of the values
    prepared: Prepared = field(repr=False)
    layout: ParameterLayout = field(repr=False)
    orientation_size: int

    @cached_property
    def held(self) -> IntArray:
        """Measured curve points whose location is no unknown, or no foot point yet."""
        linked = self.held_locations[self.prepared.chains.linked[self.held_locations]]
        return np.concatenate([np.flatnonzero(self.on_curves.kept), linked])

    @cached_property
    def curve(self) -> CurveRows:
        """Equations of measured curve points, row by row."""
        return linearize_curve_points(self.prepared, self.state, self.held_locations)

    @cached_property
    def curve_jacobian(self) -> FloatArray:
        """The same over the unknowns, (k, 6 or 0 + 3 w + 1) masked, the residual last."""
        return masked_jacobian(self.curve, self.prepared.curves, self.layout, self.orientation_size)

    @cached_property
    def windows(self) -> SegmentWindows:
        """Their windows of images and segments."""
        return SegmentWindows.of(
            self.curve, self.prepared.curves, self.layout, self.structure, self.orientation_size
        )


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
        self.pairs = PointPairs.of(observed.point, observed.image, layout.eliminated_mask)
        sigma = prepared.network.points.sigma
        weighted = np.isfinite(sigma) & (sigma > 0.0)
        self.point_inverse_sigma = np.where(weighted, 1.0 / np.where(weighted, sigma, 1.0), 0.0)
        self._blocks = CurveBlocks.of(prepared.curves, layout)
        self._structure: BlockStructure | None = None
        self._symbolic: SymbolicFactor | None = None
        self._kept_points: KeptPoints | None = None
        self._coefficients: CoefficientNormals | None = None
        self._pair_map: WindowMap | None = None
        self._normals: CurveNormals | None = None
        self._block_of_point: IntArray = np.zeros(0, dtype=np.int64)

    def with_weights(self, prepared: Prepared) -> Assembler:
        """The same measurements with other weights: pattern and ordering stay."""
        other = copy.copy(self)
        other.prepared = prepared
        if self._normals is not None:
            other._normals = self._normals.with_rays(prepared)
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
        prepared, network = self.prepared, self.prepared.network
        points = linearize_image_points(prepared, state)
        distances = linearize_distances(network.distances, state)
        priors = linearize_orientation_priors(network.images, state)
        point_prior = np.where(
            self.point_inverse_sigma > 0.0, (state.xyz - network.points.xyz) * self.point_inverse_sigma, 0.0
        )
        rows = self.coefficient_rows
        coefficient, coefficient_jacobian = (
            rows.residual(state.coefficients),
            rows.jacobian_at(state.coefficients),
        )
        linked = linearize_linked_points(prepared, state, held)
        located = Located.of(prepared, state)
        normals, coefficients, linked_windows = self._patterned(located, linked)
        values, side = coefficients.constant.copy(), np.zeros(int(self.layout.node_starts[-1]))
        is_held = np.zeros(len(network.curve_observations), dtype=bool)
        is_held[held] = True
        on_curves = ResidualsOnCurves.none(len(is_held))
        normals.add(prepared, located, is_held, values, side, on_curves)
        self._add_other_curves(state, held, values, side, on_curves)
        coefficients.add(coefficient_jacobian, coefficient, values, side)
        add_images(network, self.layout, self.structure, points, priors, values, side)
        self.kept_points.add(values, side, points, distances, self.point_inverse_sigma, point_prior)
        for window in linked_windows:
            window.add(values, side)
        self._unit_diagonal(values)
        cost = (
            float(on_curves.squares.sum()) + linked.cost + points.cost + distances.cost + priors.cost
            + float(np.sum(point_prior**2) + coefficient @ coefficient)
        )  # fmt: skip
        return Linearization(
            state, held, on_curves, linked, linked_windows, points, distances, priors, point_prior, coefficient,
            coefficient_jacobian, cost, values, side, self.structure, prepared, self.layout, self.orientation_size,
        )  # fmt: skip

    @property
    def coefficients(self) -> CoefficientNormals:
        """Equations over coefficients alone, in the present pattern."""
        if self._coefficients is None:
            raise RuntimeError("linearize first")
        return self._coefficients

    def add_curve_side(
        self, located: Located, held: BoolArray, side: FloatArray, out: ResidualsOnCurves
    ) -> None:
        """Add measured points on curves of powers to a right-hand side alone, in place; the pattern stays.

        Raises
        ------
        FloatingPointError
            If a curve point lies behind a camera, or a location has left its block.
        """
        if self._normals is None or self._blocks_change(located):
            raise FloatingPointError("a location has left its block")
        self._normals.add_right_side(self.prepared, located, held, side, out)

    def deviation(self, at: Linearization) -> float:
        """Standard deviation of unit weight as far as it is known without redundancy numbers: sqrt(v'Pv / n)."""
        network = self.prepared.network
        scalars = len(network.arc_lengths) + len(network.tangents) + len(network.distances)
        count = len(network.curve_observations) + 2 * len(network.point_observations) + scalars
        count += len(self.coefficient_rows) + at.orientation_priors.residual.size
        return float(np.sqrt(at.cost / max(1, count)))

    def eliminate(self, at: Linearization, damping: float) -> tuple[FloatArray, FloatArray, EliminatedPoints]:
        """Flat values and right-hand side of the reduced system, points eliminated, diagonal times 1 + damping.

        They are those of the linearization where nothing has to be done: not to be changed.
        """
        values, side = at.base_values, at.base_side
        if damping > 0.0 or len(self.pairs.a):
            values, side = values.copy(), side.copy()
        if damping > 0.0:
            self._scale_diagonal(values, 1.0 + damping)
        observed = self.prepared.network.point_observations
        eliminated = eliminate_points(
            at.points, observed.image, observed.point, self.layout.image_mask, self.layout.eliminated_mask,
            self.point_inverse_sigma**2, -self.point_inverse_sigma * at.point_prior_residual, damping,
        )  # fmt: skip
        if len(self.pairs.a) and self._pair_map is not None:
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
        slots = (
            [Slot(rows.image, np.zeros_like(rows.image), ORIENTATION_SIZE)] if self.orientation_size else []
        )
        window = WindowMap.of(self.structure, slots + self.slots_of_columns(columns))
        window.add(values, jacobian[:, :, None] * jacobian[:, None, :])
        return values

    def symbolic(self, state: State) -> SymbolicFactor:
        """Ordering and symbolic factor of the current pattern.

        Raises
        ------
        NotEnoughMemoryError
            If the factor will not fit.
        """
        if self._symbolic is None:
            self._symbolic = analyse(self.structure, node_positions(self.layout, state))
            require_memory(self._symbolic)
        return self._symbolic

    def slots_of_columns(self, columns: IntArray) -> list[Slot]:
        """Slots of the coefficients under windows, (G, w)."""
        return coefficient_slots(self.layout, columns)

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

    def _add_other_curves(
        self, state: State, held: IntArray, values: FloatArray, side: FloatArray, out: ResidualsOnCurves
    ) -> None:
        """Add measured points on curves whose elementary functions are no powers, in place."""
        points = np.flatnonzero(self._block_of_point < 0)
        if not len(points):
            return
        curves, size = self.prepared.curves, self.orientation_size
        rows = linearize_curve_points(self.prepared, state, held, points)
        windows = SegmentWindows.of(rows, curves, self.layout, self.structure, size)
        jacobian = masked_jacobian(rows, curves, self.layout, size)
        add_segment_windows(jacobian, windows, curves, self.layout, values, side)
        out.across[points], out.along[points] = rows.residual[: len(points)], rows.along
        out.kept[rows.point[len(points) :]] = True

    def _blocks_change(self, located: Located) -> bool:
        """Whether any location has moved to another block."""
        if self._blocks.whole_curves:
            return False
        block = self._blocks.of_segment[located.segments(self._all_points)[0]]
        return not np.array_equal(block, self._block_of_point)

    @cached_property
    def _all_points(self) -> IntArray:
        return np.arange(len(self.prepared.network.curve_observations))

    @cached_property
    def _removed(self) -> tuple[IntArray, IntArray, IntArray]:
        """Removed unknowns: their nodes, their numbers in these, and the sizes of these."""
        removed = np.flatnonzero(self.mask == 0.0)
        node = np.searchsorted(self.layout.node_starts, removed, side="right") - 1
        return node, removed - self.layout.node_starts[node], self.layout.node_sizes[node]

    def _unit_diagonal(self, values: FloatArray) -> None:
        node, local, size = self._removed
        values[self.structure.offsets[self.structure.find(node, node)] + local * (size + 1)] = 1.0

    def _patterned(
        self, located: Located, linked: LinkedEquations
    ) -> tuple[CurveNormals, CoefficientNormals, tuple[LinkedWindows, ...]]:
        """What belongs to the pattern; it grows when a location reaches a block that its image has not seen."""
        if self._normals is None or self._blocks_change(located):
            block = self._blocks.of_segment[located.segments(self._all_points)[0]]
            self._normals, self._block_of_point = None, block
        image = self.prepared.network.curve_observations.image
        windows = (
            CurveWindows.of(image, self._block_of_point, self._blocks)
            if self._normals is None
            else self._normals.windows
        )
        if self._structure is None:
            self._rebuild(windows, located, linked)
        for _ in range(2):
            try:
                if self._normals is None:
                    self._normals = CurveNormals.of(
                        self.prepared,
                        self.layout,
                        self.structure,
                        self._blocks,
                        windows,
                        self.orientation_size,
                    )
                if self._coefficients is None:
                    self._coefficients = CoefficientNormals.of(
                        self.coefficient_rows, self.layout, self.structure
                    )
                return (
                    self._normals,
                    self._coefficients,
                    tuple(
                        LinkedWindows.of(batch, self.layout, self.structure, self.orientation_size)
                        for batch in linked.batches
                    ),
                )
            except KeyError:
                self._rebuild(windows, located, linked)
        raise RuntimeError("a pair of nodes is missing in a pattern that was made for it")

    def _rebuild(self, windows: CurveWindows, located: Located, linked: LinkedEquations) -> None:
        observed, other = self.prepared.network.point_observations, np.flatnonzero(self._block_of_point < 0)
        segment = located.segments(other)[0]
        self._structure = pattern_of(
            self.prepared, self.layout, self.coefficient_rows, self._blocks, windows,
            (self.prepared.network.curve_observations.image[other], segment), linked, self.pairs,
            self.orientation_size, self._structure,
        )  # fmt: skip
        self._symbolic, self._normals, self._coefficients, self._kept_points = None, None, None, None
        if len(observed):
            a, b = observed.image[self.pairs.a], observed.image[self.pairs.b]
            zero = np.zeros_like(a)
            self._pair_map = pair_map(self._structure, Slot(a, zero, 6), Slot(b, zero, 6))
