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
    """Flat positions of all entries of G windows of P unknowns.

    A pair of different nodes is stored once: entry (p, q) and its mirror are then the same position, and only the
    one in the stored orientation counts when windows are added.
    """

    index: IntArray  # (G, P, P) position in `values`
    begins: IntArray  # (S + 1,) first unknown of every slot
    mirrored: BoolArray  # (S, S, G) slot pairs that are stored the other way round

    @classmethod
    def of(cls, structure: BlockStructure, slots: Sequence[Slot]) -> WindowMap:
        """Positions for windows made of slots.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        count, groups = len(slots), len(slots[0].node)
        begins = np.concatenate([[0], np.cumsum([slot.size for slot in slots])])
        index = np.empty((groups, int(begins[-1]), int(begins[-1])), dtype=np.int64)
        mirrored = np.zeros((count, count, groups), dtype=bool)
        for a, slot_a in enumerate(slots):
            for b in range(a, count):
                slot_b = slots[b]
                swapped = slot_a.node > slot_b.node
                low, high = np.minimum(slot_a.node, slot_b.node), np.maximum(slot_a.node, slot_b.node)
                base, width = structure.offsets[structure.find(low, high)], structure.sizes[high]
                mirrored[a, b], mirrored[b, a] = swapped, slot_a.node < slot_b.node
                rows, columns = slice(begins[a], begins[a + 1]), slice(begins[b], begins[b + 1])
                index[:, rows, columns] = _positions(base, width, swapped, slot_a, slot_b)
                if a != b:
                    other = _positions(base, width, ~swapped & (slot_a.node != slot_b.node), slot_b, slot_a)
                    index[:, columns, rows] = other
        return cls(index, begins, mirrored)

    def add(self, values: FloatArray, windows: FloatArray) -> None:
        """Add windows (G, P, P) to the flat values, in place."""
        stored = windows.copy()
        for a, b in np.argwhere(self.mirrored.any(axis=2)):
            rows = slice(int(self.begins[a]), int(self.begins[a + 1]))
            columns = slice(int(self.begins[b]), int(self.begins[b + 1]))
            if self.mirrored[a, b].all():
                stored[:, rows, columns] = 0.0
            else:
                stored[self.mirrored[a, b], rows, columns] = 0.0
        values += np.bincount(self.index.ravel(), stored.ravel(), minlength=len(values))

    def gather(self, values: FloatArray) -> FloatArray:
        """Windows (G, P, P) of a symmetric block matrix."""
        return values[self.index]


def _positions(base: IntArray, width: IntArray, swapped: BoolArray, first: Slot, second: Slot) -> IntArray:
    """Positions of the block (first, second) of every window, stored transposed where swapped."""
    down, right = np.where(swapped, 1, width), np.where(swapped, width, 1)
    corner = base + first.start * down + second.start * right
    down_steps = np.arange(first.size)[None, :, None] * down[:, None, None]
    right_steps = np.arange(second.size)[None, None, :] * right[:, None, None]
    return np.asarray(corner[:, None, None] + down_steps + right_steps)


def pair_map(structure: BlockStructure, first: Slot, second: Slot) -> WindowMap:
    """Positions of the off-diagonal blocks (first, second), first.node <= second.node, stored as they are."""
    base = structure.offsets[structure.find(first.node, second.node)]
    index = base[:, None] + np.arange(first.size * second.size)
    shape = (len(base), first.size, second.size)
    return WindowMap(index.reshape(shape), np.array([0]), np.zeros((0, 0, 0), dtype=bool))
