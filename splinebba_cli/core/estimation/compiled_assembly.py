"""Chunks of measured curve points handed to compiled kernels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from splinebba_cli.core.estimation.curve_chunk import ChunkAssembly, ChunkSums
from splinebba_cli.core.estimation.window_places import WindowPlaces
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_points import UNSETTLED

NO_MASK = np.zeros((0, 0))


@dataclass(frozen=True)
class KernelTargets:
    """Places of the parts of the windows of a chunk as the kernel wants them."""

    spans: IntArray  # (parts, 4) first and last row and column
    target: IntArray  # (parts, g) first entry of the block, in the flat values or in the sums of the chunk
    alone: BoolArray  # (parts,) whether it is in the flat values
    begins: IntArray  # (parts + 1,) first entry of the sums of every part
    slots: tuple[IntArray, IntArray]  # (g,) of the image and of the curve

    @classmethod
    def of(cls, places: WindowPlaces) -> KernelTargets:
        """From the places of a chunk."""
        parts = places.parts
        spans = np.array([(p.rows.start, p.rows.stop, p.columns.start, p.columns.stop) for p in parts])
        sizes = [0 if p.grouping is None else len(p.grouping) * p.entries for p in parts]
        begins = np.concatenate([[0], np.cumsum(sizes)])
        target = [
            p.offset if p.grouping is None else begin + p.grouping.slot * p.entries
            for p, begin in zip(parts, begins[:-1].tolist(), strict=True)
        ]
        curve = places.coefficients.grouping.slot
        image = curve if places.image is None else places.image.grouping.slot
        return cls(
            spans, np.stack(target), np.array([p.grouping is None for p in parts]), begins, (image, curve)
        )


@dataclass(frozen=True)
class CompiledAssembly:
    """One assembly by compiled kernels; the work of a thread is a chunk."""

    kernels: Any
    work: ChunkAssembly
    targets: tuple[KernelTargets, ...]

    @cached_property
    def _starts(self) -> IntArray:
        return np.searchsorted(self.work.windows.window, np.arange(len(self.work.windows) + 1))

    def sums(self, number: int) -> ChunkSums:
        """Sums of one chunk; parts of the matrix that belong to one window alone are added at once.

        Raises
        ------
        FloatingPointError
            If a point of a curve lies behind a camera.
        """
        work, places = self.work, self.work.places[number]
        chunk, targets = work.windows.chunks[number], self.targets[number]
        shared = np.zeros(int(targets.begins[-1]))
        count = int(work.blocks.count[work.windows.block[chunk.windows.start]])
        curve_side = np.zeros(places.coefficients.unknown.shape)
        image_side = np.zeros((0, 0)) if places.image is None else np.zeros(places.image.unknown.shape)
        at, prepared, out = work.at, work.prepared, work.out
        points = work.windows.points[chunk.points]
        segment, t = at.segments(points)
        front = self.kernels.chunk_sums(
            chunk.windows.start, chunk.windows.stop, self._starts, work.windows.image, work.windows.points,
            chunk.points.start, segment, t, at.polynomials, work.blocks.weights, count, work.orientation_size,
            at.state.position, at.state.rotation, prepared.principal_distance, prepared.curve_rays.xy,
            prepared.curve_rays.whitening, work.held, work.free_along, UNSETTLED,
            NO_MASK if places.mask is None else places.mask, targets.spans, targets.target, targets.alone,
            work.values, shared, targets.slots[0], image_side, targets.slots[1], curve_side,
            out.across, out.along, out.kept,
        )  # fmt: skip
        if not front:
            raise FloatingPointError("a curve point lies behind a camera")
        parts = [
            (part, shared[begin:end].reshape(-1, part.entries))
            for part, begin, end in zip(places.parts, targets.begins[:-1], targets.begins[1:], strict=True)
            if part.grouping is not None
        ]
        sides: list[tuple[IntArray, FloatArray]] = [(places.coefficients.unknown, curve_side)]
        if places.image is not None:
            sides.append((places.image.unknown, image_side))
        return ChunkSums(parts, sides)
