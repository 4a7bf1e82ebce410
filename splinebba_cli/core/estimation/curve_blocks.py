"""Blocks of segments: parts of curves whose coefficients are whole nodes of the reduced system.

All points that an image measures on one block make one dense window of the normal matrix: six unknowns of the
orientation and all coefficients of the block's nodes.  A short curve is one block.  A long one, a chain of nodes, has
a block for every node: the segments whose first coefficient it holds, and the one or two nodes after it that these
segments reach.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

NO_NODE = -1


@dataclass(frozen=True)
class CurveBlocks:
    """Tables of all blocks."""

    of_segment: IntArray  # (S,) block of a segment, -1 where its elementary functions are no powers
    nodes: IntArray  # (B, n) nodes, ascending, -1 as padding
    sizes: IntArray  # (B, n) their coefficients, 0 as padding
    columns: IntArray  # (B, b) coefficients, node by node, -1 as padding
    count: IntArray  # (B,) number of coefficients
    first_segment: IntArray  # (B,) segments of a block follow each other
    segment_count: IntArray  # (B,)
    curve: IntArray  # (B,)
    weights: FloatArray  # (S, 4, b) powers of t over the coefficients of the segment's block
    _powers: dict[int, FloatArray] = field(default_factory=dict)

    @classmethod
    def of(cls, curves: CurveSet, layout: ParameterLayout) -> CurveBlocks:
        """Blocks of all curves."""
        node = layout.node_of_coefficient[curves.columns]
        usable = ~curves.trigonometric
        segments = np.flatnonzero(usable)
        head = node[segments, 0]
        starts = np.flatnonzero(np.append(True, (head[1:] != head[:-1]) | (np.diff(segments) != 1)))
        starts = starts if len(segments) else np.zeros(0, dtype=np.int64)
        number = np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(segments))))
        of_segment = np.full(len(node), -1)
        of_segment[segments] = number
        nodes = _members(number.repeat(node.shape[1]), node[segments].ravel(), len(starts))
        sizes = np.where(nodes >= 0, layout.node_sizes[nodes] // 3, 0)
        first = _first_coefficients(layout)
        width = int(sizes.sum(axis=1).max(initial=1))
        columns = np.full((len(nodes), width), -1)
        begin = np.zeros(len(nodes), dtype=np.int64)
        for slot in range(nodes.shape[1]):
            for within in range(int(sizes[:, slot].max(initial=0))):
                rows = np.flatnonzero(sizes[:, slot] > within)
                columns[rows, begin[rows] + within] = first[nodes[rows, slot]] + within
            begin += sizes[:, slot]
        return cls(
            of_segment=of_segment,
            nodes=nodes,
            sizes=sizes,
            columns=columns,
            count=begin,
            first_segment=segments[starts],
            segment_count=np.diff(np.append(starts, len(segments))),
            curve=curves.owner[segments[starts]],
            weights=_block_weights(curves, columns, of_segment),
        )

    def __len__(self) -> int:
        return len(self.nodes)

    @cached_property
    def kind(self) -> IntArray:
        """Number of the signature of every block (the sizes of its nodes), (B,)."""
        return np.asarray(np.unique(self.sizes, axis=0, return_inverse=True)[1].ravel())

    @cached_property
    def whole_curves(self) -> bool:
        """Whether every curve of powers is one block, so that no location leaves its block."""
        return bool((np.diff(self.curve) > 0).all())

    @cached_property
    def shared(self) -> BoolArray:
        """Whether a node is part of several blocks, (highest node + 1,)."""
        return np.asarray(np.bincount(self.nodes[self.nodes >= 0]) > 1)

    def powers(self, count: int) -> FloatArray:
        """Powers of t of all segments over the first coefficients of their blocks, (4, count, S)."""
        if count not in self._powers:
            self._powers[count] = np.ascontiguousarray(self.weights[:, :, :count].transpose(1, 2, 0))
        return self._powers[count]


def _members(owner: IntArray, member: IntArray, count: int) -> IntArray:
    """Different members of every owner, ascending, padded with -1, (count, n)."""
    span = int(member.max(initial=0)) + 1
    keys = np.unique(owner * span + member)
    owners = keys // span
    place = np.arange(len(keys)) - np.searchsorted(owners, owners)
    out = np.full((count, int(place.max(initial=0)) + 1), NO_NODE)
    out[owners, place] = keys % span
    return out


def _first_coefficients(layout: ParameterLayout) -> IntArray:
    """First coefficient of every node, (nodes,); -1 of images and points."""
    first = np.full(len(layout.node_sizes), -1)
    begins = np.flatnonzero(layout.slot_of_coefficient == 0)
    first[layout.node_of_coefficient[begins]] = begins
    return first


def _block_weights(curves: CurveSet, columns: IntArray, of_segment: IntArray) -> FloatArray:
    """The basis of every segment over the coefficients of its block, (S, 4, b)."""
    out = np.zeros((len(of_segment), MAX_POWER, columns.shape[1]))
    segments = np.flatnonzero(of_segment >= 0)
    own = columns[of_segment[segments]]
    for slot in range(curves.support):
        place = np.argmax(own == curves.columns[segments, slot][:, None], axis=1)
        out[segments, :, place] += curves.power[segments, :MAX_POWER, slot]
    return out
