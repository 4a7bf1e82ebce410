"""Normal equations of measured curve points, chunk by chunk, locations eliminated.

    N += sum B'B,   h -= sum B'r      B the rows across (and along, where a location is held) of one window

In a chunk the rows of all points lie in one array whose last axis runs over the points, so that every operation is a
pass over contiguous memory and the windows of a run are one stacked product.  Working memory is that of a few chunks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.compiled_assembly import CompiledAssembly, KernelTargets
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_chunk import ChunkAssembly, ChunkSums
from splinebba_cli.core.estimation.curve_windows import CurveWindows
from splinebba_cli.core.estimation.located_points import Located, ResidualsOnCurves
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.estimation.window_places import WindowPlaces
from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.speed import compiled_kernels
from splinebba_cli.core.state import Prepared
from splinebba_cli.core.threads import in_threads

WAVE = 16
"""Chunks whose sums are held at once."""
KERNELS = "splinebba_cli.core.estimation.curve_chunk_compiled"
WORTHWHILE = 100_000
"""Points from which loading compiled kernels pays."""


@dataclass(frozen=True)
class CurveNormals:
    """Windows, their places, and measured points in the order of assembly."""

    blocks: CurveBlocks
    windows: CurveWindows
    places: tuple[WindowPlaces, ...]
    rays: MeasuredRays
    free_along: BoolArray  # (k,) points that may have an equation along: all but linked ones
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
        free_along = ~prepared.chains.linked[windows.points]
        rays = _rays_in_order(prepared, windows)
        return cls(blocks, windows, places, rays, free_along, orientation_size)

    @cached_property
    def _kernel_targets(self) -> tuple[KernelTargets, ...]:
        return tuple(KernelTargets.of(places) for places in self.places)

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
        work = self._work(prepared, at, held, values, out)
        self._add(work.sums, values, side)

    def add_right_side(
        self, prepared: Prepared, at: Located, held: BoolArray, side: FloatArray, out: ResidualsOnCurves
    ) -> None:
        """Add the right-hand side of all points alone, in place, and note their residuals.

        Raises
        ------
        FloatingPointError
            If a point of a curve lies behind a camera.
        """
        none = np.zeros(0)
        self._add(self._work(prepared, at, held, none, out).right_sides, none, side)

    def _add(self, work: Callable[[int], ChunkSums], values: FloatArray, side: FloatArray) -> None:
        chunks = list(range(len(self.places)))
        for begin in range(0, len(chunks), WAVE):
            for sums in in_threads(work, chunks[begin : begin + WAVE]):
                sums.add_to(values, side)

    def _work(
        self, prepared: Prepared, at: Located, held: BoolArray, values: FloatArray, out: ResidualsOnCurves
    ) -> ChunkAssembly | CompiledAssembly:
        """Plain or compiled."""
        for count in np.unique(self.blocks.count).tolist():
            self.blocks.powers(count)
        work = ChunkAssembly(
            self.blocks, self.windows, self.places, self.rays, self.free_along, self.orientation_size, prepared, at,
            held, values, out,
        )  # fmt: skip
        kernels = compiled_kernels(KERNELS, worthwhile=len(self.windows.points) >= WORTHWHILE)
        return work if kernels is None else CompiledAssembly(kernels, work, self._kernel_targets)


def _rays_in_order(prepared: Prepared, windows: CurveWindows) -> MeasuredRays:
    return prepared.rays_by_component[windows.points]
