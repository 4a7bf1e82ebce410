"""Where the entries of a factor lie: one flat array for all fronts.

    front f:   L₁₁ (n × n, lower triangle)  then  L₂₁ (r × n),   each in Fortran order

The same layout holds the assembled matrix before, the factor after the elimination, and the
selected inverse (Z₁₁, Z₂₁).  Hence one index array takes the values of the input matrix in and
the values of the inverse out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.block_matrix import (
    BlockStructure,
    IntArray,
    PairNotInPattern,
)
from splinebba_cli.core.estimation.fronts import FrontTree

BLOCKS = 2_000
"""Blocks whose places are computed at a time."""


@dataclass(frozen=True, eq=False)
class PanelLayout:
    """Places of all entries of the fronts of a tree.

    Attributes
    ----------
    structure : BlockStructure
    tree : FrontTree
    position : (n,) int
        Position of each node in the order of elimination.
    unknown : (n + 1,) int
        First eliminated unknown of each position.
    pivots, rows : (f,) int
        n and r of each front, in unknowns.
    offsets : (f + 1,) int
        First entry of each front.
    """

    structure: BlockStructure
    tree: FrontTree
    position: IntArray
    unknown: IntArray
    pivots: IntArray
    rows: IntArray
    offsets: IntArray

    @classmethod
    def of_tree(cls, structure: BlockStructure, tree: FrontTree) -> PanelLayout:
        """Layout of the fronts of a tree."""
        position = np.empty(len(tree.order), dtype=np.int64)
        position[tree.order] = np.arange(len(tree.order))
        sizes = structure.sizes[tree.order]
        unknown = np.concatenate([[0], np.cumsum(sizes)])
        pivots = np.diff(unknown[tree.first])
        before = np.concatenate([[0], np.cumsum(sizes[tree.row_positions])])
        rows = np.diff(before[tree.row_start])
        offsets = np.concatenate([[0], np.cumsum(pivots * (pivots + rows))])
        return cls(structure, tree, position, unknown, pivots, rows, offsets)

    @property
    def n_entries(self) -> int:
        """Length of the flat array."""
        return int(self.offsets[-1])

    @cached_property
    def permutation(self) -> IntArray:
        """Unknown of the structure that is eliminated as the k-th, (N,)."""
        s = self.structure
        order = self.tree.order
        sizes = s.sizes[order]
        within = np.arange(s.n_unknowns) - np.repeat(self.unknown[:-1], sizes)
        return np.asarray(np.repeat(s.starts[:-1][order], sizes) + within, dtype=np.int64)

    @cached_property
    def structure_entries(self) -> IntArray:
        """Place of each value of the structure in the flat array, (structure.n_entries,)."""
        s = self.structure
        places = np.empty(s.n_entries, dtype=np.int64)
        for of_shape, si, sj in s.shape_groups():
            for first in range(0, len(of_shape), BLOCKS):
                numbers = of_shape[first : first + BLOCKS]
                source = s.offsets[numbers][:, None] + np.arange(si * sj)
                places[source] = self.entries(s.rows[numbers], s.cols[numbers]).reshape(-1, si * sj)
        return places

    @cached_property
    def diagonal_entries(self) -> IntArray:
        """Place of each diagonal entry in the flat array, in the order of elimination, (N,)."""
        front = np.repeat(np.arange(len(self.pivots)), self.pivots)
        pivot = np.arange(len(front)) - self.unknown[self.tree.first][front]
        return np.asarray(self.offsets[front] + pivot * (self.pivots[front] + 1), dtype=np.int64)

    def entries(self, rows: IntArray, cols: IntArray) -> IntArray:
        """Places of the entries of blocks of equal shape.

        Parameters
        ----------
        rows, cols : (k,) int
            Pairs of nodes in either orientation; all rows of one size si, all cols of one size sj.

        Returns
        -------
        (k, si, sj) int

        Raises
        ------
        PairNotInPattern
            If a pair is not coupled in the factor.
        """
        start, leading = self.block_starts(rows, cols)
        si = np.arange(self.structure.sizes[rows[0]] if len(rows) else 0)[:, None]
        sj = np.arange(self.structure.sizes[cols[0]] if len(cols) else 0)
        turned = self.position[rows] < self.position[cols]
        step_i = np.where(turned, leading, 1)[:, None, None]
        step_j = np.where(turned, 1, leading)[:, None, None]
        places = start[:, None, None] + si * step_i + sj * step_j
        same = np.flatnonzero(rows == cols)
        if same.size:
            lower = np.maximum(si, sj) + np.minimum(si, sj) * leading[same][:, None, None]
            places[same] = start[same][:, None, None] + lower
        return np.asarray(places, dtype=np.int64)

    def block_starts(self, rows: IntArray, cols: IntArray) -> tuple[IntArray, IntArray]:
        """First entry of each block and the length of a column of its panel."""
        i, j = self.position[rows], self.position[cols]
        low, high = np.minimum(i, j), np.maximum(i, j)
        front = self._front_of[low]
        pivot = self.tree.first[front]
        n, r = self.pivots[front], self.rows[front]
        among_pivots = high < self.tree.first[front + 1]
        row = np.where(among_pivots, self.unknown[high] - self.unknown[pivot], 0)
        coupled = np.flatnonzero(~among_pivots)
        if coupled.size:
            try:
                row[coupled] = self.row_starts(front[coupled], high[coupled])
            except PairNotInPattern as missing:
                at = coupled[missing.row]
                raise PairNotInPattern(int(rows[at]), int(cols[at])) from None
        leading = np.where(among_pivots, n, r)
        column = self.unknown[low] - self.unknown[pivot]
        start = self.offsets[front] + np.where(among_pivots, 0, n * n) + column * leading + row
        return start, leading

    def row_starts(self, front: IntArray, position: IntArray) -> IntArray:
        """First row in L₂₁ of the node at a position, (k,).

        Raises
        ------
        PairNotInPattern
            With the number of the first pair whose node is no row of its front.
        """
        keys, starts = self._row_index
        key = front * len(self.position) + position
        found = np.minimum(np.searchsorted(keys, key), max(len(keys) - 1, 0))
        missing = np.flatnonzero(keys[found] != key) if len(keys) else np.arange(len(key))
        if missing.size:
            raise PairNotInPattern(int(missing[0]), -1)
        return starts[found]

    @cached_property
    def _front_of(self) -> IntArray:
        return np.repeat(np.arange(len(self.pivots)), np.diff(self.tree.first))

    @cached_property
    def _row_index(self) -> tuple[IntArray, IntArray]:
        """Sorted keys (front, position) of the rows of all fronts, first row of each in L₂₁."""
        rows = self.tree.row_positions
        front = np.repeat(np.arange(len(self.pivots)), np.diff(self.tree.row_start))
        sizes = np.diff(self.unknown)[rows]
        before = np.cumsum(sizes) - sizes
        before_front = np.cumsum(self.rows) - self.rows
        return front * len(self.position) + rows, before - before_front[front]
