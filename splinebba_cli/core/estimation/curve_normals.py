"""Normal equations of measured curve points, chunk by chunk, locations eliminated.

    N += sum B'B,   h -= sum B'r      B the rows across (and along, where a location is held) of one window

In a chunk the rows of all points lie in one array whose last axis runs over the points, so that every operation is a
pass over contiguous memory and the windows of a run are one stacked product.  Working memory is that of a few chunks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.block_sums import PartPlaces, PartSums, part_sums, sums_by
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_windows import Chunk, CurveWindows
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_point_rows import PointDirections, object_rows, orientation_rows
from splinebba_cli.core.observations.curve_points import UNSETTLED
from splinebba_cli.core.observations.photo_polynomials import (
    CurvePlaces,
    photo_polynomials,
    places_on_segments,
)
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.core.threads import in_threads

WAVE = 16
"""Chunks whose sums are held at once."""


@dataclass(frozen=True)
class ResidualsOnCurves:
    """What is kept of every measured point, (n,) each, whitened."""

    across: FloatArray
    along: FloatArray
    kept: BoolArray  # whether the equation along the curve stays: location held, or no foot point

    @classmethod
    def none(cls, count: int) -> ResidualsOnCurves:
        """Room for `count` points."""
        return cls(np.zeros(count), np.zeros(count), np.zeros(count, dtype=bool))

    @property
    def squares(self) -> FloatArray:
        """Sum of squares that every point leaves, (n,)."""
        return np.asarray(self.across**2 + np.where(self.kept, self.along, 0.0) ** 2)


@dataclass(frozen=True)
class WindowPlaces:
    """Where the parts of the windows of one chunk go."""

    parts: tuple[PartPlaces, ...]
    image_unknown: IntArray  # (g, 6)
    block_unknown: IntArray  # (g, 3 b)
    mask: FloatArray | None  # (g, P) 0 where an unknown is removed; None where none is

    @classmethod
    def of(
        cls, structure: BlockStructure, layout: ParameterLayout, blocks: CurveBlocks, windows: CurveWindows,
        chunk: Chunk, orientation_size: int,
    ) -> WindowPlaces:  # fmt: skip
        """Places of a chunk.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        image, block = windows.image[chunk.windows], windows.block[chunk.windows]
        nodes = blocks.nodes[block]
        nodes = nodes[:, nodes[0] >= 0]
        columns = blocks.columns[block][:, : blocks.count[block[0]]]
        mask = layout.coefficient_mask[columns].reshape(len(block), -1)
        if orientation_size:
            nodes = np.concatenate([image[:, None], nodes], axis=1)
            mask = np.concatenate([layout.image_mask[image], mask], axis=1)
        begins = np.concatenate([[0], np.cumsum(structure.sizes[nodes[0]])])
        parts = tuple(
            PartPlaces.of(structure, nodes, a, b, begins)
            for a in range(nodes.shape[1])
            for b in range(a, nodes.shape[1])
        )
        unknown = layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)
        return cls(
            parts,
            ORIENTATION_SIZE * image[:, None] + np.arange(ORIENTATION_SIZE),
            unknown.reshape(len(block), -1),
            None if mask.all() else mask,
        )


@dataclass(frozen=True)
class CurveNormals:
    """Windows, their places, and measured points in the order of assembly."""

    blocks: CurveBlocks
    windows: CurveWindows
    places: tuple[WindowPlaces, ...]
    rays: MeasuredRays
    linked: BoolArray  # (k,)
    orientation_size: int

    @classmethod
    def of(
        cls, prepared: Prepared, layout: ParameterLayout, structure: BlockStructure, blocks: CurveBlocks,
        windows: CurveWindows, orientation_size: int,
    ) -> CurveNormals:  # fmt: skip
        """Places of all windows in a pattern.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        places = tuple(
            WindowPlaces.of(structure, layout, blocks, windows, chunk, orientation_size)
            for chunk in windows.chunks
        )
        linked = prepared.chains.linked[windows.points]
        rays = _rays_in_order(prepared, windows)
        return cls(blocks, windows, places, rays, linked, orientation_size)

    def with_rays(self, prepared: Prepared) -> CurveNormals:
        """The same with the image points and weights of another preparation."""
        return replace(self, rays=_rays_in_order(prepared, self.windows))

    def add(
        self, prepared: Prepared, at: Located, held: BoolArray, values: FloatArray, side: FloatArray,
        out: ResidualsOnCurves,
    ) -> None:  # fmt: skip
        """Add normal matrix and right-hand side of all points, in place, and note their residuals.

        Parameters
        ----------
        held : (n,) whether the location of a measured point is held

        Raises
        ------
        FloatingPointError
            If a point of a curve lies behind a camera.
        """
        for count in np.unique(self.blocks.count).tolist():
            self.blocks.powers(count)
        job = _Assembly(self, prepared, at, held, values, out)
        chunks = list(range(len(self.places)))
        for begin in range(0, len(chunks), WAVE):
            for sums in in_threads(job.chunk, chunks[begin : begin + WAVE]):
                sums.add_to(values, side)


def _rays_in_order(prepared: Prepared, windows: CurveWindows) -> MeasuredRays:
    return prepared.rays_by_component[windows.points]


@dataclass(frozen=True)
class Located:
    """A state with the segments of all measured points."""

    state: State
    polynomials: FloatArray  # (S, 4, 3) of the object frame
    segment: IntArray  # (n,)
    t: FloatArray  # (n,)

    @classmethod
    def of(cls, prepared: Prepared, state: State) -> Located:
        """Segments at the present locations."""
        curves = prepared.curves
        segment, t = curves.locate(prepared.network.curve_observations.curve, state.location)
        return cls(state, curves.segment_polynomials(state.coefficients)[:, :4], segment, t)


@dataclass(frozen=True)
class _ChunkSums:
    """Sums of a chunk, to be added in the order of the chunks."""

    parts: list[PartSums]
    sides: list[tuple[IntArray, FloatArray]]  # unknowns and what belongs to them

    def add_to(self, values: FloatArray, side: FloatArray) -> None:
        for part in self.parts:
            part.add_to(values)
        for unknown, sums in self.sides:
            np.add.at(side, unknown, sums)


@dataclass(frozen=True)
class _Assembly:
    """One assembly, the work of a thread being a chunk."""

    normals: CurveNormals
    prepared: Prepared
    at: Located
    held: BoolArray
    values: FloatArray
    out: ResidualsOnCurves

    def chunk(self, number: int) -> _ChunkSums:
        """Sums of one chunk; parts of the matrix that belong to one window alone are added at once."""
        normals, places = self.normals, self.normals.places[number]
        chunk = normals.windows.chunks[number]
        matrices = self._window_matrices(chunk)
        if places.mask is not None:
            mask = np.concatenate([places.mask, np.ones((len(matrices), 1))], axis=1)
            matrices *= mask[:, :, None]
            matrices *= mask[:, None, :]
        shared = []
        for part in places.parts:
            sums = part_sums(part, matrices)
            if part.alone:
                sums.add_to(self.values)
            else:
                shared.append(sums)
        right, size = -matrices[:, :-1, -1], normals.orientation_size
        sides = [_side_sums(places.block_unknown, right[:, size:])]
        if size:
            sides.append(_side_sums(places.image_unknown, right[:, :size]))
        return _ChunkSums(shared, sides)

    def _window_matrices(self, chunk: Chunk) -> FloatArray:
        """[B r]'[B r] of every window of a chunk, (g, P + 1, P + 1)."""
        rows, kept, along = self._rows(chunk)
        width = len(rows)
        matrices = np.empty((chunk.windows.stop - chunk.windows.start, width, width))
        for run in chunk.runs:
            points = slice(run.points.start - chunk.points.start, run.points.stop - chunk.points.start)
            windows = slice(run.windows.start - chunk.windows.start, run.windows.stop - chunk.windows.start)
            own = rows[:, points].reshape(width, -1, run.length).transpose(1, 0, 2)
            np.matmul(own, own.transpose(0, 2, 1), out=matrices[windows])
        if len(kept):
            window = self.normals.windows.window[chunk.points][kept] - chunk.windows.start
            np.add.at(matrices, window, along.T[:, :, None] * along.T[:, None, :])
        return matrices

    def _rows(self, chunk: Chunk) -> tuple[FloatArray, IntArray, FloatArray]:
        """Rows across (P + 1, n) with the residual last; points with a row along, and these rows."""
        normals = self.normals
        number = normals.windows.points[chunk.points]
        seen = _Seen.of(normals, self.prepared, self.at, chunk)
        rays = normals.rays[chunk.points]
        directions = PointDirections.of(seen.places, rays)
        flagged = (self.held[number] | (np.abs(directions.along) > UNSETTLED)) & ~normals.linked[chunk.points]
        self.out.across[number], self.out.along[number] = directions.across, directions.along
        self.out.kept[number] = flagged
        normal = np.stack([-directions.unit[1], directions.unit[0]])
        h = directions.gradients(rays.whitening, normal)
        rows = seen.rows(h, directions.across, normals.orientation_size)
        kept = np.flatnonzero(flagged)
        if not len(kept):
            return rows, kept, rows[:, :0]
        h = directions.gradients(rays.whitening, directions.unit)[:, kept]
        return rows, kept, seen[kept].rows(h, directions.along[kept], normals.orientation_size)


def _side_sums(unknown: IntArray, right: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sums of right-hand sides (g, e) of windows over the same unknowns (g, e)."""
    one, sums = sums_by(unknown[:, 0], right)
    return unknown[one], sums


@dataclass(frozen=True)
class _Seen:
    """Points of a chunk as their images see them."""

    places: CurvePlaces
    weights: FloatArray  # (b, n) of the coefficients of the block
    rotation: FloatArray  # (3, 3, n)
    distance: FloatArray  # (n,) principal distances

    @classmethod
    def of(cls, normals: CurveNormals, prepared: Prepared, at: Located, chunk: Chunk) -> _Seen:
        windows, blocks = normals.windows, normals.blocks
        image, block = windows.image[chunk.windows], windows.block[chunk.windows]
        number = windows.points[chunk.points]
        window = windows.window[chunk.points] - chunk.windows.start
        first, count = blocks.first_segment[block], blocks.segment_count[block]
        longest = int(count.max())
        segments = first[:, None] + np.minimum(np.arange(longest), count[:, None] - 1)
        distance = prepared.principal_distance
        table = photo_polynomials(at.polynomials, distance, at.state, image, segments)
        segment, t = at.segment[number], at.t[number]
        places = places_on_segments(table, window * longest + segment - first[window], t)
        powers = blocks.powers(int(blocks.count[block[0]]))
        a = np.take(powers, segment, axis=2, mode="clip")
        weights = t * a[3]
        for k in (2, 1, 0):
            weights += a[k]
            if k:
                weights *= t
        rotation = np.take(at.state.rotation[image].transpose(1, 2, 0), window, axis=2)
        return cls(places, weights, rotation, distance[image][window])

    def __getitem__(self, points: IntArray) -> _Seen:
        places = CurvePlaces(
            self.places.value[:, points], self.places.first[:, points], self.places.second[:, points]
        )
        return _Seen(places, self.weights[:, points], self.rotation[:, :, points], self.distance[points])

    def rows(self, h: FloatArray, residual: FloatArray, orientation_size: int) -> FloatArray:
        """Derivatives over orientation and coefficients and the residual, (P + 1, n).

        Parameters
        ----------
        h : (3, n) d/dp, p scaled as in the tables
        """
        size, count = orientation_size, len(self.weights)
        rows = np.empty((size + 3 * count + 1, len(residual)))
        h[:2] *= -self.distance
        g = rows[3:6] if size else np.empty((3, len(residual)))
        object_rows(h, self.rotation, g)
        np.multiply(self.weights[:, None], g, out=rows[size:-1].reshape(count, 3, -1))
        if size:
            p = self.places.value.copy()
            p[:2] /= -self.distance
            orientation_rows(h, p, rows[:3])
            np.negative(g, out=g)
        rows[-1] = residual
        return rows
