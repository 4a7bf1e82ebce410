"""From small dense windows to the flat values of a block matrix, and back.

A window couples a few slots (an image, the coefficients under one curve segment); many windows of equal shape are
added to the sparse matrix, or read from the selected inverse, in one go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Slot:
    """One block of unknowns of every window."""

    node: IntArray  # (G,)
    start: IntArray  # (G,) first unknown inside the node
    size: int


@dataclass(frozen=True)
class WindowMap:
    """Flat positions of all entries of G windows of P unknowns."""

    index: IntArray  # (G, P, P) position in `values`; entry (p, q) and its mirror may be the same position
    canonical: BoolArray  # (G, P, P) whether the entry is stored in this orientation

    @classmethod
    def of(cls, structure: BlockStructure, slots: Sequence[Slot]) -> WindowMap:
        """Positions for windows made of slots.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        size = sum(slot.size for slot in slots)
        groups = len(slots[0].node)
        index = np.empty((groups, size, size), dtype=np.int64)
        canonical = np.empty((groups, size, size), dtype=bool)
        begins = np.concatenate([[0], np.cumsum([slot.size for slot in slots])])
        for a, slot_a in enumerate(slots):
            for b, slot_b in enumerate(slots):
                swapped = slot_a.node > slot_b.node
                low = np.where(swapped, slot_b.node, slot_a.node)
                high = np.where(swapped, slot_a.node, slot_b.node)
                base = structure.offsets[structure.find(low, high)]
                width = structure.sizes[high]
                row = slot_a.start[:, None, None] + np.arange(slot_a.size)[None, :, None]
                column = slot_b.start[:, None, None] + np.arange(slot_b.size)[None, None, :]
                mirrored = swapped[:, None, None]
                inside = np.where(mirrored, column, row) * width[:, None, None] + np.where(
                    mirrored, row, column
                )
                block = (slice(None), slice(begins[a], begins[a + 1]), slice(begins[b], begins[b + 1]))
                index[block] = base[:, None, None] + inside
                canonical[block] = ~mirrored
        return cls(index, canonical)

    def add(self, values: FloatArray, windows: FloatArray) -> None:
        """Add windows (G, P, P) to the flat values, in place."""
        weights = (windows * self.canonical).ravel()
        values += np.bincount(self.index.ravel(), weights, minlength=len(values))

    def gather(self, values: FloatArray) -> FloatArray:
        """Windows (G, P, P) of a symmetric block matrix."""
        return values[self.index]
