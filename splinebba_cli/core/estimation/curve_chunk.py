"""Normal equations of one chunk of measured curve points, in plain numpy.

The rows of all points lie in one array whose last axis runs over the points, so that every operation is a pass over
contiguous memory and the windows of a run are one stacked product.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_sums import PartPlaces
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_windows import Chunk, CurveWindows
from splinebba_cli.core.estimation.located_points import Located, ResidualsOnCurves
from splinebba_cli.core.estimation.seen_points import SeenPoints
from splinebba_cli.core.estimation.window_places import WindowPlaces
from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_point_rows import PointDirections
from splinebba_cli.core.observations.curve_points import UNSETTLED
from splinebba_cli.core.state import Prepared


@dataclass(frozen=True)
class ChunkSums:
    """Sums of a chunk, to be added in the order of the chunks."""

    parts: list[tuple[PartPlaces, FloatArray]]
    sides: list[tuple[IntArray, FloatArray]]  # unknowns and what belongs to them

    def add_to(self, values: FloatArray, side: FloatArray) -> None:
        """Add to flat values and right-hand side, in place."""
        for part, sums in self.parts:
            part.add(sums, values)
        for unknown, sums in self.sides:
            np.add.at(side, unknown, sums)


@dataclass(frozen=True)
class ChunkAssembly:
    """One assembly; the work of a thread is a chunk."""

    blocks: CurveBlocks
    windows: CurveWindows
    places: tuple[WindowPlaces, ...]
    rays: MeasuredRays  # in the order of assembly
    free_along: BoolArray  # (k,) points that may have an equation along: all but linked ones
    orientation_size: int
    prepared: Prepared
    at: Located
    held: BoolArray  # (n,)
    values: FloatArray
    out: ResidualsOnCurves

    def sums(self, number: int) -> ChunkSums:
        """Sums of one chunk; parts of the matrix that belong to one window alone are added at once."""
        places = self.places[number]
        matrices = self._window_matrices(self.windows.chunks[number])
        if places.mask is not None:
            mask = np.concatenate([places.mask, np.ones((len(matrices), 1))], axis=1)
            matrices *= mask[:, :, None]
            matrices *= mask[:, None, :]
        shared = []
        for part in places.parts:
            sums = part.sums(matrices)
            if part.grouping is None:
                part.add(sums, self.values)
            else:
                shared.append((part, sums))
        return ChunkSums(shared, self._sides(places, -matrices[:, :-1, -1]))

    def right_sides(self, number: int) -> ChunkSums:
        """The right-hand sides of one chunk alone."""
        chunk, places = self.windows.chunks[number], self.places[number]
        rows, kept, along = self._rows(chunk)
        window = self.windows.window[chunk.points] - chunk.windows.start
        starts = np.flatnonzero(np.append(True, window[1:] != window[:-1]))
        right = np.add.reduceat(rows[:-1] * -rows[-1], starts, axis=1).T
        if len(kept):
            np.subtract.at(right, window[kept], (along[:-1] * along[-1]).T)
        if places.mask is not None:
            right *= places.mask
        return ChunkSums([], self._sides(places, right))

    def _sides(self, places: WindowPlaces, right: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """Sums of right-hand sides (g, P) of windows by their unknowns."""
        size, of_curve = self.orientation_size, places.coefficients
        sides = [(of_curve.unknown, of_curve.grouping.sums(right[:, size:]))]
        if places.image is not None:
            sides.append((places.image.unknown, places.image.grouping.sums(right[:, :size])))
        return sides

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
            window = self.windows.window[chunk.points][kept] - chunk.windows.start
            np.add.at(matrices, window, along.T[:, :, None] * along.T[:, None, :])
        return matrices

    def _rows(self, chunk: Chunk) -> tuple[FloatArray, IntArray, FloatArray]:
        """Rows across (P + 1, n) with the residual last; points with a row along, and these rows."""
        number = self.windows.points[chunk.points]
        seen = SeenPoints.of(self.windows, self.blocks, self.prepared, self.at, chunk)
        rays = self.rays[chunk.points]
        directions = PointDirections.of(seen.places, rays)
        flagged = (self.held[number] | (np.abs(directions.along) > UNSETTLED)) & self.free_along[chunk.points]
        self.out.across[number], self.out.along[number] = directions.across, directions.along
        self.out.kept[number] = flagged
        normal = np.stack([-directions.unit[1], directions.unit[0]])
        h = directions.gradients(rays, normal)
        rows = seen.rows(h, directions.across, self.orientation_size)
        kept = np.flatnonzero(flagged)
        if not len(kept):
            return rows, kept, rows[:, :0]
        h = directions.gradients(rays, directions.unit)[:, kept]
        return rows, kept, seen[kept].rows(h, directions.along[kept], self.orientation_size)
