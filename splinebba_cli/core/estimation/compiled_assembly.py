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

    @cached_property
    def _curve(self) -> IntArray:
        observed = self.work.prepared.network.curve_observations
        return observed.curve[self.work.windows.points[self._starts[:-1]]]

    def sums(self, number: int) -> ChunkSums:
        """Sums of one chunk; parts of the matrix that belong to one window alone are added at once.

        Raises
        ------
        FloatingPointError
            If a point of a curve lies behind a camera.
        """
        work, places, targets = self.work, self.work.places[number], self.targets[number]
        shared, sides = np.zeros(int(targets.begins[-1])), self._empty_sides(number)
        front = self.kernels.chunk_sums(
            *self._measured(number), targets.spans, targets.target, targets.alone, work.values, shared,
            targets.slots[0], sides[0], targets.slots[1], sides[1],
            work.out.across, work.out.along, work.out.kept,
        )  # fmt: skip
        _require_front(front)
        parts = [
            (part, shared[begin:end].reshape(-1, part.entries))
            for part, begin, end in zip(places.parts, targets.begins[:-1], targets.begins[1:], strict=True)
            if part.grouping is not None
        ]
        return ChunkSums(parts, self._sides(number, *sides))

    def right_sides(self, number: int) -> ChunkSums:
        """The right-hand sides of one chunk alone.

        Raises
        ------
        FloatingPointError
            If a point of a curve lies behind a camera.
        """
        targets, sides, out = self.targets[number], self._empty_sides(number), self.work.out
        front = self.kernels.chunk_sides(
            *self._measured(number), targets.slots[0], sides[0], targets.slots[1], sides[1],
            out.across, out.along, out.kept,
        )  # fmt: skip
        _require_front(front)
        return ChunkSums([], self._sides(number, *sides))

    def _measured(self, number: int) -> tuple[Any, ...]:
        """What is measured in a chunk and where, as both kernels want it."""
        work, at, prepared = self.work, self.work.at, self.work.prepared
        chunk, mask = work.windows.chunks[number], work.places[number].mask
        curves = prepared.curves
        count = int(work.blocks.count[work.windows.block[chunk.windows.start]])
        return (
            chunk.windows.start, chunk.windows.stop, self._starts, work.windows.image, self._curve,
            work.windows.points, at.state.location, at.polynomials, curves.left, curves.length,
            curves.segment_start, curves.first, curves.last, curves.closed, work.blocks.weights, count,
            work.orientation_size,
            at.state.position, at.state.rotation, prepared.principal_distance, prepared.curve_rays.xy,
            prepared.curve_rays.whitening, work.held, work.free_along, UNSETTLED, NO_MASK if mask is None else mask,
        )  # fmt: skip

    def _empty_sides(self, number: int) -> tuple[FloatArray, FloatArray]:
        places = self.work.places[number]
        image = np.zeros((0, 0)) if places.image is None else np.zeros(places.image.unknown.shape)
        return image, np.zeros(places.coefficients.unknown.shape)

    def _sides(self, number: int, image: FloatArray, curve: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """Unknowns and their right-hand sides."""
        places = self.work.places[number]
        sides = [(places.coefficients.unknown, curve)]
        return sides if places.image is None else [*sides, (places.image.unknown, image)]


def _require_front(front: bool) -> None:
    if not front:
        raise FloatingPointError("a curve point lies behind a camera")
