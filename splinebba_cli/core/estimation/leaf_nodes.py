"""Nodes that are eliminated first and each by itself: curves that few images see.

Eliminating a node couples all its neighbours.  Where a node is heavier than each of them and they are few, that is
always cheap, so that only the rest needs an ordering (global nodes come last in any case and do not count):

    A = [A_leaves   B ]      pattern of the rest  =  pattern of C  ∪  neighbours of one leaf, all with all
        [Bᵀ         C ]

No two leaves are coupled, because neither of two neighbours can be the heavier one of both.

References
----------
Brown, D. C. (1958): A solution to the general problem of multiple station analytical stereotriangulation. RCA
    Technical Report 43 (reduced normal equations of the images).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from splinebba_cli.core.estimation.block_matrix import BlockStructure, IntArray

LEAF_ROWS = 90
"""Most unknowns of the neighbours of a leaf, without global ones."""
ALL_ROWS = 128
"""Most unknowns of all neighbours of a leaf."""
LEAF_PIVOTS = 30
"""Most unknowns of a leaf."""


@dataclass(frozen=True, eq=False)
class Leaves:
    """Leaves and their neighbours.

    Attributes
    ----------
    nodes : (k,) int
        The leaves, ascending.
    start : (k + 1,) int
        First neighbour of each leaf in `neighbours`.
    neighbours : (m,) int
        Nodes that are coupled with a leaf, leaf by leaf.
    """

    nodes: IntArray
    start: IntArray
    neighbours: IntArray

    @property
    def counts(self) -> IntArray:
        """Neighbours of each leaf, (k,)."""
        return np.diff(self.start)


def find_leaves(structure: BlockStructure, everywhere: npt.NDArray[np.bool_]) -> Leaves:
    """The leaves of a pattern.

    Parameters
    ----------
    everywhere : (n,) bool
        Global nodes, which are no leaves.
    """
    off = np.flatnonzero(structure.rows != structure.cols)
    node = np.concatenate([structure.rows[off], structure.cols[off]])
    other = np.concatenate([structure.cols[off], structure.rows[off]])
    sizes, n = structure.sizes, structure.n_nodes
    rows = np.bincount(node, sizes[other], n)
    counted = np.where(everywhere, 0, sizes)
    heaviest = np.zeros(n, dtype=np.int64)
    np.maximum.at(heaviest, node, counted[other])
    few = (np.bincount(node, counted[other], n) <= LEAF_ROWS) & (rows <= ALL_ROWS)
    return _leaves((heaviest < sizes) & few & (sizes <= LEAF_PIVOTS) & ~everywhere, node, other)


def no_leaves() -> Leaves:
    """None at all."""
    none = np.zeros(0, dtype=np.int64)
    return Leaves(none, np.zeros(1, dtype=np.int64), none)


def _leaves(chosen: npt.NDArray[np.bool_], node: IntArray, other: IntArray) -> Leaves:
    of_leaves = np.flatnonzero(chosen[node])
    of_leaves = of_leaves[np.argsort(node[of_leaves], kind="stable")]
    nodes = np.flatnonzero(chosen)
    start = np.searchsorted(node[of_leaves], np.append(nodes, len(chosen)))
    return Leaves(nodes, start, other[of_leaves])


def without_leaves(structure: BlockStructure, leaves: Leaves) -> tuple[BlockStructure, IntArray]:
    """Pattern of the rest after the leaves are eliminated, and the nodes that it consists of.

    Returns
    -------
    rest : BlockStructure
    nodes : (r,) int
        Node of the structure that each node of the rest is, ascending.
    """
    if not leaves.nodes.size:
        return structure, np.arange(structure.n_nodes)
    stays = np.ones(structure.n_nodes, dtype=bool)
    stays[leaves.nodes] = False
    nodes = np.flatnonzero(stays)
    number = np.cumsum(stays) - 1
    inside = stays[structure.rows] & stays[structure.cols]
    first, second = [structure.rows[inside]], [structure.cols[inside]]
    for count in np.unique(leaves.counts).tolist():
        those = leaves.start[:-1][leaves.counts == count]
        group = leaves.neighbours[those[:, None] + np.arange(count)]
        i, j = np.triu_indices(count, 1)
        first.append(group[:, i].ravel())
        second.append(group[:, j].ravel())
    pairs = number[np.concatenate(first)], number[np.concatenate(second)]
    return BlockStructure.from_pairs(structure.sizes[nodes], *pairs), nodes
