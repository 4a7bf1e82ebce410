"""Fronts: unknowns that are eliminated together, and those they leave connected.

A front eliminates the n pivots of a few nodes and couples them with the r unknowns ("rows") that
come later:

    rows(f) = (neighbours of the pivots of f  ∪  rows of the fronts below f)  −  pivots of f
    parent(f) = the front that eliminates the first of rows(f)

Leaves come first, each a front of its own, those of equal shape one behind the other.  Of the rest, small
fronts are merged with their parents where the zeros that are then computed cost less than another front does.

References
----------
Duff, I. S., Reid, J. K. (1983): The multifrontal solution of indefinite sparse symmetric
    linear equations. ACM TOMS 9, 302-325.
Ashcraft, C., Grimes, R. (1989): The influence of relaxed supernode partitions on the
    multifrontal method. ACM TOMS 15, 291-309.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure, FloatArray, IntArray
from splinebba_cli.core.estimation.leaf_nodes import Leaves
from splinebba_cli.core.estimation.ordering import Dissection

Number = TypeVar("Number", float, FloatArray)


@dataclass(frozen=True)
class FrontCosts:
    """What fronts cost beside their operations, in floating-point operations.

    Attributes
    ----------
    front : float
        Handling one more front.
    move : float
        Adding one entry of an update to the parent.
    """

    front: float
    move: float


PLAIN = FrontCosts(front=4.0e5, move=20.0)
"""Fronts that Python handles."""
COMPILED = FrontCosts(front=4.0e4, move=10.0)
"""Fronts that compiled kernels handle."""


@dataclass(frozen=True, eq=False)
class FrontTree:
    """Fronts in the order in which they are eliminated, each after those below it.

    Attributes
    ----------
    order : (n,) int
        Nodes in the order of elimination; "position" is a place in it.
    first : (f + 1,) int
        First position of each front's pivots.
    row_start : (f + 1,) int
        First row of each front in `row_positions`.
    row_positions : (R,) int
        Positions of the nodes that a front couples its pivots with, ascending, front by front.
    parent : (f,) int
        Parent of each front, larger than the front itself; -1 for a root.
    n_leaves : int
        How many of the first fronts are leaves; those that are coupled with nothing are the last of them.
    """

    order: IntArray
    first: IntArray
    row_start: IntArray
    row_positions: IntArray
    parent: IntArray
    n_leaves: int = 0

    @property
    def n_coupled(self) -> int:
        """How many leaves are coupled with something."""
        return int(np.searchsorted(self.row_start[: self.n_leaves + 1], self.row_start[self.n_leaves]))

    def rows(self, front: int) -> IntArray:
        """Rows of one front, ascending positions."""
        return self.row_positions[self.row_start[front] : self.row_start[front + 1]]


def build_fronts(structure: BlockStructure, dissection: Dissection, costs: FrontCosts = PLAIN) -> FrontTree:
    """Fronts of a dissected structure, small ones merged with their parents."""
    order, first = _order_of_parts(dissection)
    tree, rows = _assembly_tree(structure, order, first)
    target = _merge_targets(structure, tree, costs)
    return _merged(tree, target, rows)


def with_leaves(structure: BlockStructure, leaves: Leaves, rest: FrontTree, nodes: IntArray) -> FrontTree:
    """The tree of all nodes: leaves before the fronts of the rest, sorted by shape and then by parent.

    Parameters
    ----------
    rest : FrontTree
        Of the pattern without the leaves, whose nodes are ``nodes`` of the structure.
    """
    k = len(leaves.nodes)
    if k == 0:
        return rest
    position = np.full(structure.n_nodes, -1, dtype=np.int64)
    position[nodes[rest.order]] = k + np.arange(len(nodes))
    leaf = np.repeat(np.arange(k), leaves.counts)
    rows = position[leaves.neighbours]
    earliest = np.full(k, -1, dtype=np.int64)
    has_rows = leaves.counts > 0
    earliest[has_rows] = np.minimum.reduceat(rows, leaves.start[:-1][has_rows]) if rows.size else 0
    above = np.where(has_rows, k + np.searchsorted(rest.first + k, earliest, side="right") - 1, -1)
    of_rows = structure.sizes[leaves.neighbours]
    unknowns, divisor = np.bincount(leaf, of_rows, k), np.ones(k, dtype=np.int64)
    divisor[has_rows] = np.gcd.reduceat(of_rows, leaves.start[:-1][has_rows]) if rows.size else 1
    by_shape = np.lexsort((above, divisor, unknowns, structure.sizes[leaves.nodes], ~has_rows))
    place = np.empty(k, dtype=np.int64)
    place[by_shape] = np.arange(k)
    sorted_rows = np.lexsort((rows, place[leaf]))
    row_start = np.concatenate([[0], np.cumsum(leaves.counts[by_shape])])
    return FrontTree(
        order=np.concatenate([leaves.nodes[by_shape], nodes[rest.order]]),
        first=np.concatenate([np.arange(k), k + rest.first]),
        row_start=np.concatenate([row_start[:-1], row_start[-1] + rest.row_start]),
        row_positions=np.concatenate([rows[sorted_rows], k + rest.row_positions]),
        parent=np.concatenate([above[by_shape], np.where(rest.parent >= 0, k + rest.parent, -1)]),
        n_leaves=k,
    )


def front_operations(pivots: Number, rows: Number) -> Number:
    """Floating-point operations to eliminate the pivots of a front: n³/3 + n² r + n r²."""
    return pivots * (pivots * pivots / 3.0 + pivots * rows + rows * rows)


def _order_of_parts(dissection: Dissection) -> tuple[IntArray, IntArray]:
    """Nodes in the order of elimination and first position of each part that has nodes."""
    parent = dissection.parent
    rank = _postorder_rank(parent)
    order = np.argsort(rank[dissection.part], kind="stable")
    used, count = np.unique(rank[dissection.part], return_counts=True)
    first = np.zeros(len(used) + 1, dtype=np.int64)
    np.cumsum(count, out=first[1:])
    return order, first


def _postorder_rank(parent: IntArray) -> IntArray:
    """Place of each vertex of a forest in a depth-first order, children before their parent."""
    children: list[list[int]] = [[] for _ in parent]
    stack: list[int] = []
    for vertex, above in enumerate(parent.tolist()):
        (children[above] if above >= 0 else stack).append(vertex)
    rank = np.empty(len(parent), dtype=np.int64)
    place = len(parent)
    while stack:
        vertex = stack.pop()
        place -= 1
        rank[vertex] = place
        stack.extend(children[vertex])
    return rank


def _assembly_tree(
    structure: BlockStructure, order: IntArray, first: IntArray
) -> tuple[FrontTree, list[IntArray]]:
    """The fronts whose pivots are first[f] .. first[f + 1], and their rows front by front."""
    n, n_fronts = len(order), len(first) - 1
    position = np.empty(n, dtype=np.int64)
    position[order] = np.arange(n)
    front_of = np.repeat(np.arange(n_fronts), np.diff(first))
    i, j = position[structure.rows], position[structure.cols]
    low, high = np.minimum(i, j), np.maximum(i, j)
    outside = front_of[low] != front_of[high]
    keys = np.unique(front_of[low[outside]] * n + high[outside])
    own = np.split(keys % n, np.searchsorted(keys, np.arange(1, n_fronts) * n)) if n_fronts else []
    below: list[list[IntArray]] = [[] for _ in range(n_fronts)]
    rows: list[IntArray] = []
    parent = np.full(n_fronts, -1, dtype=np.int64)
    for front, neighbours in enumerate(own):
        if below[front]:
            union = np.unique(np.concatenate([neighbours, *below[front]]))
            neighbours = union[np.searchsorted(union, first[front + 1]) :]
            below[front] = []
        rows.append(neighbours)
        if neighbours.size:
            parent[front] = front_of[neighbours[0]]
            below[parent[front]].append(neighbours)
    return FrontTree(order, first, *_joined(rows), parent), rows


def _joined(rows: list[IntArray]) -> tuple[IntArray, IntArray]:
    """Arrays one behind the other: (first of each, all)."""
    start = np.zeros(len(rows) + 1, dtype=np.int64)
    np.cumsum([len(r) for r in rows], out=start[1:])
    return start, np.concatenate([np.zeros(0, dtype=np.int64), *rows])


def _merge_targets(structure: BlockStructure, tree: FrontTree, costs: FrontCosts) -> IntArray:
    """The front into which each front is merged (itself if it stays)."""
    sizes = structure.sizes[tree.order]
    pivots = np.add.reduceat(sizes, tree.first[:-1]).tolist() if len(sizes) else []
    before = np.concatenate([[0], np.cumsum(sizes[tree.row_positions])])
    rows = np.diff(before[tree.row_start]).tolist()
    children: list[list[int]] = [[] for _ in rows]
    target = np.arange(len(rows))
    for front, above in enumerate(tree.parent.tolist()):
        candidates = sorted(children[front], key=pivots.__getitem__)
        children[front] = []
        for child in candidates:
            if _merging_pays(costs, pivots[child], rows[child], pivots[front], rows[front]):
                target[child] = front
                pivots[front] += pivots[child]
                candidates.extend(children[child])
            else:
                children[front].append(child)
        if above >= 0:
            children[above].append(front)
    for front in range(len(target) - 1, -1, -1):
        target[front] = target[target[front]]
    return target


def _merging_pays(costs: FrontCosts, child_pivots: int, child_rows: int, pivots: int, rows: int) -> bool:
    apart = front_operations(child_pivots, child_rows) + front_operations(pivots, rows)
    together = front_operations(child_pivots + pivots, rows)
    return together - apart < costs.front + costs.move * child_rows * child_rows


def _merged(tree: FrontTree, target: IntArray, old_rows: list[IntArray]) -> FrontTree:
    """The tree after merging, its fronts and positions numbered anew."""
    stays = np.flatnonzero(target == np.arange(len(target)))
    number = np.full(len(target), -1, dtype=np.int64)
    number[stays] = np.arange(len(stays))
    above = tree.parent[stays]
    parent = np.where(above >= 0, number[target[above]], -1)
    rank = _postorder_rank(parent)
    by_rank = np.argsort(rank)
    front_of = rank[number[target]].repeat(np.diff(tree.first))
    old_position = np.argsort(front_of, kind="stable")
    new_position = np.empty_like(old_position)
    new_position[old_position] = np.arange(len(old_position))
    first = np.searchsorted(front_of[old_position], np.arange(len(stays) + 1))
    rows = [np.sort(new_position[old_rows[f]]) for f in stays[by_rank].tolist()]
    new_parent = np.where(parent >= 0, rank[parent], -1)[by_rank]
    return FrontTree(tree.order[old_position], first, *_joined(rows), new_parent)
