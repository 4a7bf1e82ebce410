"""Chains of linked points in the reduced normal equations: windows of an image and all coefficients under a chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.estimation.window_map import Slot, WindowMap
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.linked_points import LinkedBatch


@dataclass(frozen=True)
class LinkedWindows:
    """One batch of chains over the unknowns of the reduced system."""

    batch: LinkedBatch
    window: WindowMap
    unknowns: IntArray  # (G, P) number of every column in the reduced system
    mask: FloatArray  # (G, P) 0 where an unknown is removed
    orientation_size: int  # 6, or 0 where all orientations are held

    @classmethod
    def of(
        cls, batch: LinkedBatch, layout: ParameterLayout, structure: BlockStructure, orientation_size: int
    ) -> LinkedWindows:
        """Positions of a batch.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        image, columns = batch.image, batch.columns
        slots = [Slot(image, np.zeros_like(image), ORIENTATION_SIZE)] if orientation_size else []
        slots += [Slot(layout.node_of_coefficient[c], layout.slot_of_coefficient[c], 3) for c in columns.T]
        first = layout.unknown_of_coefficient[columns]
        unknowns = (first[:, :, None] + np.arange(3)).reshape(len(image), -1)
        mask = layout.coefficient_mask[columns].reshape(len(image), -1)
        if orientation_size:
            own = ORIENTATION_SIZE * image[:, None] + np.arange(ORIENTATION_SIZE)
            unknowns = np.concatenate([own, unknowns], axis=1)
            mask = np.concatenate([layout.image_mask[image], mask], axis=1)
        return cls(batch, WindowMap.of(structure, slots), unknowns, mask, orientation_size)

    def masked(self, rows: FloatArray) -> FloatArray:
        """Rows (G, R, 6 + 3 m + 1) over the unknowns that are not removed, without the residual, (G, R, P)."""
        return rows[:, :, ORIENTATION_SIZE - self.orientation_size : -1] * self.mask[:, None, :]

    def add(self, values: FloatArray, side: FloatArray) -> None:
        """Add K'K to the flat values and -K'r to the right-hand side, in place."""
        kept = self.masked(self.batch.eliminated.kept)
        self.window.add(values, np.matmul(kept.transpose(0, 2, 1), kept))
        residual = self.batch.eliminated.kept[:, :, -1:]
        np.subtract.at(side, self.unknowns, np.matmul(kept.transpose(0, 2, 1), residual)[:, :, 0])


def linked_pairs(
    batch: LinkedBatch, layout: ParameterLayout, orientation_size: int
) -> tuple[IntArray, IntArray]:
    """Pairs of nodes that a batch couples."""
    nodes = layout.node_of_coefficient[batch.columns]
    if orientation_size:
        nodes = np.concatenate([batch.image[:, None], nodes], axis=1)
    nodes = np.unique(nodes, axis=0)
    first = np.repeat(nodes, nodes.shape[1], axis=1).ravel()
    second = np.tile(nodes, (1, nodes.shape[1])).ravel()
    return first, second
