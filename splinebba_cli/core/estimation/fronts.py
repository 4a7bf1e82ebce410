"""Fronts: unknowns that are eliminated together, and those they leave connected.

A front eliminates the n pivots of a few nodes and couples them with the r unknowns ("rows") that
come later:

    rows(f) = (neighbours of the pivots of f  ∪  rows of the fronts below f)  −  pivots of f
    parent(f) = the front that eliminates the first of rows(f)

Small fronts are merged with their parents where the zeros that are then computed cost less than
another front does.

References
----------
Duff, I. S., Reid, J. K. (1983): The multifrontal solution of indefinite sparse symmetric
    linear equations. ACM TOMS 9, 302-325.
Ashcraft, C., Grimes, R. (1989): The influence of relaxed supernode partitions on the
    multifrontal method. ACM TOMS 15, 291-309.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.block_matrix import BlockStructure, IntArray
from splinebba_cli.core.estimation.ordering import Dissection

FRONT_COST = 4.0e5
"""What handling one more front costs, in floating-point operations."""
MOVE_COST = 20.0
"""What adding one entry of an update to the parent costs, in floating-point operations."""


@dataclass(frozen=True, eq=False)
class FrontTree:
    """Fronts in the order in which they are eliminated, each after those below it.

    Attributes
    ----------
    order : (n,) int
        Nodes in the order of elimination; "position" is a place in it.
    first : (f + 1,) int
        First position of each front's pivots.
    rows : list of f (·,) int
        Positions of the nodes that a front couples its pivots with, ascending.
    parent : (f,) int
        Parent of each front, larger than the front itself; -1 for a root.
    """

    order: IntArray
    first: IntArray
    rows: list[IntArray]
    parent: IntArray


def build_fronts(structure: BlockStructure, dissection: Dissection) -> FrontTree:
    """Fronts of a dissected structure, small ones merged with their parents."""
    order, first = _order_of_parts(dissection)
    tree = _assembly_tree(structure, order, first)
    target = _merge_targets(structure, tree)
    return _merged(tree, target)


def front_operations(pivots: float, rows: float) -> float:
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


def _assembly_tree(structure: BlockStructure, order: IntArray, first: IntArray) -> FrontTree:
    """Rows and parents of the fronts whose pivots are first[f] .. first[f + 1]."""
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
    return FrontTree(order, first, rows, parent)


def _merge_targets(structure: BlockStructure, tree: FrontTree) -> IntArray:
    """The front into which each front is merged (itself if it stays)."""
    sizes = structure.sizes[tree.order]
    pivots = np.add.reduceat(sizes, tree.first[:-1]).tolist() if len(sizes) else []
    rows = [int(sizes[r].sum()) for r in tree.rows]
    children: list[list[int]] = [[] for _ in rows]
    target = np.arange(len(rows))
    for front, above in enumerate(tree.parent.tolist()):
        candidates = sorted(children[front], key=pivots.__getitem__)
        children[front] = []
        for child in candidates:
            if _merging_pays(pivots[child], rows[child], pivots[front], rows[front]):
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


def _merging_pays(child_pivots: int, child_rows: int, pivots: int, rows: int) -> bool:
    apart = front_operations(child_pivots, child_rows) + front_operations(pivots, rows)
    together = front_operations(child_pivots + pivots, rows)
    return together - apart < FRONT_COST + MOVE_COST * child_rows * child_rows


def _merged(tree: FrontTree, target: IntArray) -> FrontTree:
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
    rows = [np.sort(new_position[tree.rows[f]]) for f in stays[by_rank].tolist()]
    new_parent = np.where(parent >= 0, rank[parent], -1)[by_rank]
    return FrontTree(tree.order[old_position], first, rows, new_parent)
