"""Sums of dense blocks in the flat values of a block matrix, where every block is a whole block of the pattern.

Windows couple nodes n_1 < n_2 < ...; the part (a, b) of a window belongs to the block (n_a, n_b), which is stored in
this orientation, row by row, in one piece.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class PartPlaces:
    """Where one part of all windows goes."""

    rows: slice  # of the window
    columns: slice
    offset: IntArray  # (G,) first entry of the block in the flat values
    alone: bool  # whether every block gets one window only

    @classmethod
    def of(cls, structure: BlockStructure, nodes: IntArray, a: int, b: int, begins: IntArray) -> PartPlaces:
        """Part (a, b) of windows of nodes (G, n) that begin at unknowns `begins` (n + 1,).

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        block = structure.find(nodes[:, a], nodes[:, b])
        alone = len(np.unique(block)) == len(block)
        return cls(
            slice(int(begins[a]), int(begins[a + 1])), slice(int(begins[b]), int(begins[b + 1])),
            structure.offsets[block], alone,
        )  # fmt: skip


@dataclass(frozen=True)
class PartSums:
    """Sums of one part over the windows of a chunk."""

    offset: IntArray  # (u,) different blocks
    sums: FloatArray  # (u, entries)

    def add_to(self, values: FloatArray) -> None:
        """Add to the flat values, in place."""
        values[self.offset[:, None] + np.arange(self.sums.shape[1])] += self.sums


def part_sums(part: PartPlaces, matrices: FloatArray) -> PartSums:
    """Sums of a part of window matrices (G, P, P) by block."""
    blocks = matrices[:, part.rows, part.columns].reshape(len(matrices), -1)
    if part.alone:
        return PartSums(part.offset, blocks)
    one, sums = sums_by(part.offset, blocks)
    return PartSums(part.offset[one], sums)


def sums_by(key: IntArray, rows: FloatArray) -> tuple[IntArray, FloatArray]:
    """Sums of rows (g, e) of equal key: one row of every key (u,), and the sums (u, e)."""
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    starts = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1])) if len(key) else order
    if len(starts) == len(key):
        return order, rows[order]
    return order[starts], np.add.reduceat(rows[order], starts, axis=0)
