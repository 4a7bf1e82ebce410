"""Where the windows of a chunk of measured curve points go in the normal equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.block_sums import Grouping, PartPlaces
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_windows import Chunk, CurveWindows
from splinebba_cli.core.estimation.parameters import ORIENTATION_SIZE, ParameterLayout
from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class SidePlaces:
    """Unknowns of one kind under the windows of a chunk."""

    unknown: IntArray  # (u, e) of every target
    grouping: Grouping

    @classmethod
    def of(cls, unknown: IntArray) -> SidePlaces:
        """Targets of windows over unknowns (g, e), told apart by the first of them."""
        grouping = Grouping.of(unknown[:, 0])
        return cls(unknown[grouping.one], grouping)


@dataclass(frozen=True)
class WindowPlaces:
    """Where the parts of the windows of one chunk go."""

    parts: tuple[PartPlaces, ...]
    image: SidePlaces | None  # None where all orientations are held
    coefficients: SidePlaces
    mask: FloatArray | None  # (g, P) 0 where an unknown is removed; None where none is

    @classmethod
    def of(
        cls, structure: BlockStructure, layout: ParameterLayout, blocks: CurveBlocks, windows: CurveWindows,
        chunk: Chunk, orientation_size: int,
    ) -> WindowPlaces:  # fmt: skip
        """Places of a chunk.

        Raises
        ------
        KeyError
            If a pair of nodes is not in the pattern.
        """
        image, block = windows.image[chunk.windows], windows.block[chunk.windows]
        nodes = blocks.nodes[block]
        nodes = nodes[:, nodes[0] >= 0]
        own = ~blocks.shared[nodes]
        columns = blocks.columns[block][:, : blocks.count[block[0]]]
        mask = layout.coefficient_mask[columns].reshape(len(block), -1)
        if orientation_size:
            nodes = np.concatenate([image[:, None], nodes], axis=1)
            own = np.concatenate([np.zeros((len(image), 1), dtype=bool), own], axis=1)
            mask = np.concatenate([layout.image_mask[image], mask], axis=1)
        begins = np.concatenate([[0], np.cumsum(structure.sizes[nodes[0]])])
        parts = tuple(
            PartPlaces.of(structure, nodes, a, b, begins, own[:, b])
            for a in range(nodes.shape[1])
            for b in range(a, nodes.shape[1])
        )
        unknown = layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)
        of_image = ORIENTATION_SIZE * image[:, None] + np.arange(orientation_size)
        return cls(
            parts,
            SidePlaces.of(of_image) if orientation_size else None,
            SidePlaces.of(unknown.reshape(len(block), -1)),
            None if mask.all() else mask,
        )
