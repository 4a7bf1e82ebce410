"""Sums of dense blocks in the flat values of a block matrix, where every block is a whole block of the pattern.

Windows couple nodes n_1 < n_2 < ...; the part (a, b) of a window belongs to the block (n_a, n_b), which is stored in
this orientation, row by row, in one piece.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Grouping:
    """Rows that belong to the same target."""

    order: IntArray  # (g,) rows, target by target
    starts: IntArray  # (u,) first place of every target in `order`
    slot: IntArray  # (g,) number of the target of every row

    @classmethod
    def of(cls, key: IntArray) -> Grouping:
        """Group rows by key, (g,)."""
        order = np.argsort(key, kind="stable")
        ordered = key[order]
        first = np.append(True, ordered[1:] != ordered[:-1]) if len(key) else np.zeros(0, dtype=bool)
        slot = np.empty(len(key), dtype=np.int64)
        slot[order] = np.cumsum(first) - 1
        return cls(order, np.flatnonzero(first), slot)

    def __len__(self) -> int:
        return len(self.starts)

    @property
    def one(self) -> IntArray:
        """One row of every target, (u,)."""
        return self.order[self.starts]

    def sums(self, rows: FloatArray) -> FloatArray:
        """Sums of rows (g, e) by target, (u, e)."""
        if len(self.starts) == len(self.order):
            return rows[self.order]
        return np.add.reduceat(rows[self.order], self.starts, axis=0)


@dataclass(frozen=True)
class PartPlaces:
    """Where one part of all windows goes."""

    rows: slice  # of the window
    columns: slice
    offset: IntArray  # (u,) first entry of every block in the flat values
    grouping: Grouping | None  # None where every block gets one window only, of all that there are

    @classmethod
    def of(
        cls, structure: BlockStructure, nodes: IntArray, a: int, b: int, begins: IntArray, own: BoolArray
    ) -> PartPlaces:
        """Part (a, b) of windows of nodes (G, n) that begin at unknowns `begins` (n + 1,).

        Parameters
        ----------
        own : (G,) whether no window but these reaches the second node

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        block = structure.find(nodes[:, a], nodes[:, b])
        grouping = Grouping.of(block)
        alone = len(grouping) == len(block) and bool(own.all())
        rows, columns = (slice(int(begins[k]), int(begins[k + 1])) for k in (a, b))
        chosen = block if alone else block[grouping.one]
        return cls(rows, columns, structure.offsets[chosen], None if alone else grouping)

    @property
    def entries(self) -> int:
        """Entries of one block."""
        return int((self.rows.stop - self.rows.start) * (self.columns.stop - self.columns.start))

    def sums(self, matrices: FloatArray) -> FloatArray:
        """Sums of this part of window matrices (G, P, P) by block, (u, entries)."""
        blocks = matrices[:, self.rows, self.columns].reshape(len(matrices), -1)
        return blocks if self.grouping is None else self.grouping.sums(blocks)

    def add(self, sums: FloatArray, values: FloatArray) -> None:
        """Add sums (u, entries) to the flat values, in place."""
        values[self.offset[:, None] + np.arange(self.entries)] += sums
