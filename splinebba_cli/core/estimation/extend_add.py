"""Where the update of a front goes in its parent, and where the parent's inverse is taken from.

The r rows of a front are, in its parent, partly pivots (the first k) and partly rows:

    update = [U₁₁      ]   U₁₁ → A₁₁ of the parent,   U₂₁ → A₂₁,   U₂₂ → the parent's own update
             [U₂₁  U₂₂ ]

Only lower triangles are meaningful; positions ascend in every front, so lower goes to lower.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import FloatArray, IntArray
from splinebba_cli.core.estimation.panel_layout import PanelLayout

Index = IntArray | slice


@dataclass(frozen=True, eq=False)
class RowPlaces:
    """Rows of all fronts, unknown by unknown.

    Attributes
    ----------
    start : (f + 1,) int
        First row of each front in `unknown` and `place`.
    unknown : (R,) int
        Each row among all unknowns in the order of elimination.
    place : (R,) int
        Each row in the parent of its front: among the pivots (below n), or n + its place among the rows.
    split : (f,) int
        How many rows of each front are pivots of its parent.
    """

    start: IntArray
    unknown: IntArray
    place: IntArray
    split: IntArray


def row_places(layout: PanelLayout) -> RowPlaces:
    """Rows of all fronts of a layout."""
    tree = layout.tree
    n_fronts, rows = len(tree.parent), tree.row_positions
    front = np.repeat(np.arange(n_fronts), np.diff(tree.row_start))
    above = tree.parent[front]
    first = layout.unknown[rows]
    place = first - layout.unknown[tree.first[above]]
    later = np.flatnonzero(rows >= tree.first[above + 1])
    place[later] = layout.pivots[above[later]] + layout.row_starts(above[later], rows[later])
    sizes = layout.unknown[rows + 1] - first
    among_pivots = np.ones(len(rows), dtype=bool)
    among_pivots[later] = False
    start = np.concatenate([[0], np.cumsum(layout.rows)])
    split = np.bincount(front, sizes * among_pivots, n_fronts).astype(np.int64)
    return RowPlaces(start, _expand(first, sizes), _expand(place, sizes), split)


@dataclass(frozen=True, eq=False, slots=True)
class UpdateTarget:
    """Indices of one front.

    Attributes
    ----------
    pivots : slice
        Its pivots among all unknowns in the order of elimination.
    rows : (r,) int or slice
        Its rows among them.
    split : int
        How many of its rows are pivots of the parent.
    pivots_in_parent, rows_in_parent : (split,), (r − split,) int or slice
        Their places among the parent's pivots and rows.
    """

    pivots: slice
    rows: Index
    split: int
    pivots_in_parent: Index
    rows_in_parent: Index

    def add(self, update: FloatArray, top: FloatArray, below: FloatArray, waiting: FloatArray) -> None:
        """Add U₁₁, U₂₁ and U₂₂ to the parent's A₁₁, A₂₁ and update."""
        k = self.split
        _add_block(top, self.pivots_in_parent, self.pivots_in_parent, update[:k, :k])
        if k < len(update):
            _add_block(below, self.rows_in_parent, self.pivots_in_parent, update[k:, :k])
            _add_block(waiting, self.rows_in_parent, self.rows_in_parent, update[k:, k:])

    def take(self, top: FloatArray, below: FloatArray, remaining: FloatArray) -> FloatArray:
        """Lower triangle of the parent's matrix on this front's rows, (r, r), Fortran order."""
        k, rows = self.split, self.rows_in_parent
        r = k + (rows.stop - rows.start if isinstance(rows, slice) else len(rows))
        taken = np.empty((r, r), order="F")
        taken[:k, :k] = top[_pair(self.pivots_in_parent, self.pivots_in_parent)]
        if k < r:
            taken[k:, :k] = below[_pair(rows, self.pivots_in_parent)]
            taken[k:, k:] = remaining[_pair(rows, rows)]
        return taken


def update_target(layout: PanelLayout, places: RowPlaces, front: int) -> UpdateTarget:
    """Indices of one front of a layout."""
    tree, unknown = layout.tree, layout.unknown
    pivots = slice(int(unknown[tree.first[front]]), int(unknown[tree.first[front + 1]]))
    parent = int(tree.parent[front])
    if parent < 0:
        return UpdateTarget(pivots, slice(0, 0), 0, slice(0, 0), slice(0, 0))
    rows = slice(int(places.start[front]), int(places.start[front + 1]))
    place, k = places.place[rows], int(places.split[front])
    return UpdateTarget(
        pivots,
        _as_slice(places.unknown[rows]),
        k,
        _as_slice(place[:k]),
        _as_slice(place[k:] - layout.pivots[parent]),
    )


def _expand(starts: IntArray, sizes: IntArray) -> IntArray:
    """The numbers starts[i] .. starts[i] + sizes[i] − 1 of all i, one behind the other."""
    before = np.cumsum(sizes) - sizes
    return np.asarray(np.arange(int(sizes.sum())) + np.repeat(starts - before, sizes), dtype=np.int64)


def _as_slice(index: IntArray) -> Index:
    """A slice if the ascending index has no gap; it is copied faster."""
    if len(index) == 0:
        return slice(0, 0)
    if index[-1] - index[0] == len(index) - 1:
        return slice(int(index[0]), int(index[-1]) + 1)
    return index


def _pair(rows: Index, cols: Index) -> tuple[Index, Index]:
    """Index of the block rows × cols."""
    if isinstance(rows, slice) or isinstance(cols, slice):
        return rows, cols
    return rows[:, None], cols


def _add_block(target: FloatArray, rows: Index, cols: Index, block: FloatArray) -> None:
    target[_pair(rows, cols)] += block
