"""All fronts of a factor through compiled kernels, parts of the assembly tree side by side.

Results are those of the plain way through `block_cholesky` and `selected_inverse`, to rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise
from typing import Any

import numpy as np

from splinebba_cli.core.estimation.blas_threads import LARGE_FRONT, one_thread
from splinebba_cli.core.estimation.block_matrix import FloatArray, IntArray
from splinebba_cli.core.estimation.extend_add import RowPlaces
from splinebba_cli.core.estimation.panel_layout import PanelLayout
from splinebba_cli.core.estimation.schedule import Schedule, schedule
from splinebba_cli.core.speed import compiled_kernels
from splinebba_cli.core.threads import in_threads, thread_count

WORTHWHILE = 20_000
"""Unknowns from which on the kernels save more than loading them costs (some five factorisations)."""
FEW = 4
"""Right-hand sides up to which the kernels solve; more of them are a matter for BLAS."""
_PACKAGE = "splinebba_cli.core.estimation"


def factor_kernels(n_unknowns: int) -> Any:
    """Kernels of factorisation and solution, or None where plain numpy is to be used."""
    return compiled_kernels(f"{_PACKAGE}.block_cholesky_compiled", worthwhile=n_unknowns >= WORTHWHILE)


def inverse_kernels(n_unknowns: int) -> Any:
    """Kernels of the selected inverse, or None where plain numpy is to be used."""
    return compiled_kernels(f"{_PACKAGE}.selected_inverse_compiled", worthwhile=n_unknowns >= WORTHWHILE)


@dataclass(frozen=True, eq=False)
class CompiledFronts:
    """What kernels need to know about a layout.

    Attributes
    ----------
    layout : PanelLayout
    places : RowPlaces
    n_parts : int
        Parts that are worked on side by side.
    """

    layout: PanelLayout
    places: RowPlaces
    n_parts: int

    @classmethod
    def of(cls, layout: PanelLayout, places: RowPlaces) -> CompiledFronts:
        """For the threads of this process."""
        return cls(layout, places, thread_count())

    @cached_property
    def schedule(self) -> Schedule:
        """Order of work and places in the working memory."""
        return schedule(self.layout, self.n_parts)

    @cached_property
    def lonely(self) -> IntArray:
        """Leaves that are coupled with nothing."""
        return np.arange(self.layout.tree.n_coupled, self.layout.tree.n_leaves)

    @cached_property
    def _factor_plan(self) -> tuple[IntArray | int, ...]:
        layout, places, order = self.layout, self.places, self.schedule
        first = layout.unknown[layout.tree.first[:-1]]
        return (
            layout.pivots, layout.rows, layout.offsets, first, places.start, places.unknown, places.place,
            places.split, order.child_start, order.children, order.update, layout.tree.n_leaves,
        )  # fmt: skip

    @cached_property
    def _inverse_plan(self) -> tuple[IntArray | int, ...]:
        layout, places, order = self.layout, self.places, self.schedule
        return (
            layout.pivots, layout.rows, layout.offsets, layout.tree.parent, places.start, places.place,
            places.split, order.child_start, order.children, order.outer, layout.tree.n_leaves,
        )  # fmt: skip

    @cached_property
    def _blocks(self) -> tuple[IntArray, ...]:
        """Of each block of the structure: offset, rows, columns, first entry in the panel, steps there."""
        s = self.layout.structure
        start, leading = self.layout.block_starts(s.rows, s.cols)
        turned = self.layout.position[s.rows] < self.layout.position[s.cols]
        steps = np.where(turned, leading, 1), np.where(turned, 1, leading)
        return s.offsets, s.sizes[s.rows], s.sizes[s.cols], start, *steps

    def put(self, kernels: Any, values: FloatArray, panel: FloatArray) -> None:
        """Values of the structure to their places in the panel."""
        in_threads(lambda part: kernels.put(*part, self._blocks, values, panel), self._ranges_of_blocks())

    def get(self, kernels: Any, panel: FloatArray) -> FloatArray:
        """Values of the structure from their places in the panel."""
        values = np.empty(self.layout.structure.n_entries)
        diagonal = self.layout.structure.rows == self.layout.structure.cols
        in_threads(
            lambda part: kernels.get(*part, self._blocks, diagonal, panel, values), self._ranges_of_blocks()
        )
        return values

    def _ranges_of_blocks(self) -> list[tuple[int, int]]:
        """First block and end of each part, about equally many entries."""
        offsets = self.layout.structure.offsets
        bounds = np.searchsorted(offsets, np.linspace(0, offsets[-1], self.n_parts + 1))
        return list(pairwise(bounds.tolist()))

    def eliminate(self, kernels: Any, panel: FloatArray) -> bool:
        """Replace the assembled matrix by its factor; False where a pivot is not positive."""
        plan, work = self._factor_plan, np.empty(self.schedule.update_size)
        with one_thread():
            done = [kernels.eliminate_lonely(self.lonely, plan, panel)]
            done += in_threads(lambda part: kernels.eliminate(part, plan, panel, work), self.schedule.parts)
        return all(done) and all(self._over_top(lambda run: kernels.eliminate(run, plan, panel, work)))

    def solve(self, kernels: Any, panel: FloatArray, x: FloatArray) -> None:
        """Solve L Lᵀ x = x in place, x (N,) in the order of elimination."""
        plan, top = self._factor_plan, self.schedule.top
        changes = [np.zeros(len(x)) for _ in self.schedule.parts]
        kernels.forward_lonely(self.lonely, plan, panel, x)
        in_threads(
            lambda job: kernels.forward(job[0], plan, panel, x, job[1]),
            list(zip(self.schedule.parts, changes, strict=True)),
        )
        for change in changes[1:]:
            changes[0] += change
        kernels.forward(top, plan, panel, x, changes[0])
        kernels.backward(top, plan, panel, x)
        in_threads(lambda part: kernels.backward(part, plan, panel, x), self.schedule.parts)
        kernels.backward_lonely(self.lonely, plan, panel, x)

    def invert(self, kernels: Any, panel: FloatArray, selected: FloatArray) -> None:
        """Z₁₁ and Z₂₁ of all fronts but for leaves that are coupled with others."""
        plan, work = self._inverse_plan, np.empty(self.schedule.outer_size)
        kernels.invert_lonely(self.lonely, plan, panel, selected)
        self._over_top(lambda run: kernels.invert_fronts(run, plan, panel, selected, work), backwards=-1)
        with one_thread():
            in_threads(
                lambda part: kernels.invert_fronts(part, plan, panel, selected, work), self.schedule.parts
            )

    def invert_leaves(self, kernels: Any, panel: FloatArray, selected: FloatArray) -> None:
        """Z₁₁ and Z₂₁ of the leaves that are coupled with others."""
        plan, work = self._inverse_plan, np.empty(self.schedule.outer_size)
        kernels.invert_leaves(self.schedule.top, plan, panel, selected, work)
        in_threads(lambda part: kernels.invert_leaves(part, plan, panel, selected, work), self.schedule.parts)

    def _over_top(self, work: Callable[[IntArray], Any], backwards: int = 1) -> list[Any]:
        """Work on the top, large fronts with all threads of BLAS."""
        done = []
        sizes = self.layout.pivots + self.layout.rows
        runs = groupby(self.schedule.top[::backwards].tolist(), key=lambda front: sizes[front] >= LARGE_FRONT)
        for large, run in runs:
            with nullcontext() if large else one_thread():
                done.append(work(np.sort(np.fromiter(run, dtype=np.int64))))
        return done
