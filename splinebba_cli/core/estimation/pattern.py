"""Which nodes of the reduced system couple.

A curve couples with the images that see it, the nodes of a curve with each other where a segment touches both, images
with each other by common object points.  The pattern already holds what a location would reach in the next block.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.block_matrix import BlockStructure
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_windows import CurveWindows
from splinebba_cli.core.estimation.elimination import PointPairs
from splinebba_cli.core.estimation.kept_points import kept_pairs
from splinebba_cli.core.estimation.linked_windows import linked_pairs
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import IntArray
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows
from splinebba_cli.core.observations.linked_points import LinkedEquations
from splinebba_cli.core.state import Prepared

Pairs = tuple[IntArray, IntArray]


def pattern_of(
    prepared: Prepared, layout: ParameterLayout, rows: CoefficientRows, blocks: CurveBlocks,
    windows: CurveWindows, other: Pairs, linked: LinkedEquations, points: PointPairs,
    orientation_size: int, before: BlockStructure | None,
) -> BlockStructure:  # fmt: skip
    """Pattern of the reduced normal matrix.

    Parameters
    ----------
    other : (image, segment) of measured points that are in no window
    orientation_size : 6, or 0 where all orientations are held
    before : a pattern whose pairs are kept
    """
    node, curves = layout.node_of_coefficient, prepared.curves
    pairs = [(before.rows, before.cols)] if before is not None else []
    pairs += [_pairs_under(node, table) for table in (curves.columns, rows.columns)]
    pairs += list(_all_pairs(blocks.nodes))
    if orientation_size:
        pairs += list(_seen_blocks(blocks, windows, layout))
        pairs += list(_seen_segments(curves, *other, node))
    pairs += [linked_pairs(batch, layout, orientation_size) for batch in linked.batches]
    observed = prepared.network.point_observations
    pairs.append((observed.image[points.a], observed.image[points.b]))
    pairs += list(kept_pairs(prepared.network, layout))
    first, second = (np.concatenate(side) for side in zip(*pairs, strict=True))
    return BlockStructure.from_pairs(layout.node_sizes, first, second)


def _pairs_under(node: IntArray, table: IntArray) -> Pairs:
    """Different nodes that one row of a table of coefficients touches."""
    nodes = node[table]
    first, second = [], []
    for i in range(nodes.shape[1]):
        for j in range(i):
            different = nodes[:, i] != nodes[:, j]
            first.append(nodes[different, i])
            second.append(nodes[different, j])
    none = np.zeros(0, dtype=np.int64)
    return np.concatenate([none, *first]), np.concatenate([none, *second])


def _all_pairs(nodes: IntArray) -> list[Pairs]:
    """Pairs of nodes of every block, padded with -1."""
    found = []
    for i in range(nodes.shape[1]):
        for j in range(i):
            both = nodes[:, i] >= 0
            found.append((nodes[both, j], nodes[both, i]))
    return found


def _seen_blocks(blocks: CurveBlocks, windows: CurveWindows, layout: ParameterLayout) -> list[Pairs]:
    """Images and nodes of the blocks that they see, and of the neighbours of these on the same curve."""
    found = []
    curve = layout.node_curve[blocks.nodes[:, 0]] if len(blocks) else np.zeros(0, dtype=np.int64)
    for step in (-1, 0, 1):
        near = np.clip(windows.block + step, 0, len(blocks) - 1)
        same = (near - windows.block == step) & (curve[near] == curve[windows.block])
        for slot in range(blocks.nodes.shape[1]):
            nodes = blocks.nodes[near, slot]
            used = same & (nodes >= 0)
            found.append((windows.image[used], nodes[used]))
    return found


def _seen_segments(curves: CurveSet, image: IntArray, segment: IntArray, node: IntArray) -> list[Pairs]:
    """Images and nodes under the segments that they see, and under the next ones."""
    found = []
    curve = np.searchsorted(curves.segment_start, segment, side="right")
    for step in (-1, 0, 1):
        near = np.clip(segment + step, 0, max(len(curves.left) - 1, 0))
        same = np.searchsorted(curves.segment_start, near, side="right") == curve
        under = node[curves.columns[near[same]]]
        found += [(image[same], under[:, slot]) for slot in range(curves.support)]
    return found
