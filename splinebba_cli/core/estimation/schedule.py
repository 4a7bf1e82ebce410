"""Which thread does which fronts, and where their updates wait meanwhile.

Disjoint subtrees of the assembly tree are independent of each other: each part takes some of them, and the top of
the tree follows when all parts are done (for the inverse: goes before).

    post-order     the update of a front waits until its parent takes it.  Fronts of even and of odd depth have a
                   stack each: when a front comes, its children lie on top of the other stack
    top-down       Z₂₂ of a front waits until the fronts below it have taken theirs: a stack along the path, but
                   for the top, where all of them wait for the parts

References
----------
Liu, J. W. H. (1992): The multifrontal method for sparse matrix solution. SIAM Review 34, 82-109, sections 4 and 5.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np

from splinebba_cli.core.estimation.block_matrix import FloatArray, IntArray
from splinebba_cli.core.estimation.fronts import front_operations
from splinebba_cli.core.estimation.panel_layout import PanelLayout

SUBTREES = 8
"""Divisions that are tried for each part, so that the parts come out about equal."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """Order of work and places in the working memory.

    Attributes
    ----------
    parts : tuple of (·,) int
        Fronts of each part, ascending.
    top : (t,) int
        Fronts above all of them, ascending.
    child_start, children : (f + 2,), (f,) int
        Fronts below each front, ascending; behind the last front those without a parent.
    update : (f,) int
        First entry of the update of each front; leaves have none.
    update_size : int
        Length of the working memory of the factorisation.
    outer : (f,) int
        First entry of Z₂₂ of each front.
    outer_size : int
        Length of the working memory of the selected inverse.
    n_leaves : int
        How many of the first fronts are leaves.
    """

    parts: tuple[IntArray, ...]
    top: IntArray
    child_start: IntArray
    children: IntArray
    update: IntArray
    update_size: int
    outer: IntArray
    outer_size: int
    n_leaves: int

    def below(self, front: int) -> list[int]:
        """Fronts below a front, but for leaves."""
        children = self.children[self.child_start[front] : self.child_start[front + 1]]
        return [child for child in children.tolist() if child >= self.n_leaves]


def schedule(layout: PanelLayout, n_parts: int) -> Schedule:
    """Schedule of the fronts of a layout for so many threads."""
    parent, n_fronts = layout.tree.parent, len(layout.pivots)
    above = np.where(parent < 0, n_fronts, parent)
    children = np.argsort(above, kind="stable")
    child_start = np.searchsorted(above[children], np.arange(n_fronts + 2))
    part = _part_of_fronts(layout, children, child_start, n_parts)
    fronts = np.arange(layout.tree.n_leaves, n_fronts)
    of_fronts = part[fronts]
    groups = [fronts[of_fronts == p] for p in range(n_parts)]
    top = fronts[of_fronts < 0]
    squares, update, outer = (
        layout.rows**2,
        np.zeros(n_fronts, dtype=np.int64),
        np.zeros(n_fronts, dtype=np.int64),
    )
    update_size = 0
    depth = _depths(parent)
    for group in [top, *groups]:
        update_size = _stack_updates(group, parent, depth, squares, update, update_size)
    outer[top] = np.cumsum(squares[top]) - squares[top]
    outer_size = int(squares[top].sum())
    for group in groups:
        outer_size = _stack_outers(group, parent, squares, outer, outer_size)
    return Schedule(
        tuple(groups),
        top,
        child_start,
        children,
        update,
        update_size,
        outer,
        outer_size,
        layout.tree.n_leaves,
    )


def _part_of_fronts(layout: PanelLayout, children: IntArray, child_start: IntArray, n_parts: int) -> IntArray:
    """Part of each front that is no leaf, -1 for the top, (f,).

    The heaviest subtree is divided into those below it as long as that may shorten the longest part and the top.
    """
    work = _work_of_subtrees(layout)
    n_leaves, parent = layout.tree.n_leaves, layout.tree.parent
    roots = np.flatnonzero(parent[n_leaves:] < 0) + n_leaves
    subtrees = [(-float(work[root]), root) for root in roots.tolist()]
    heapify(subtrees)
    of_top, best, chosen = 0.0, np.inf, _assigned(subtrees, n_parts)
    for _ in range(SUBTREES * n_parts):
        assigned = _assigned(subtrees, n_parts)
        duration = of_top + max(float(work[fronts].sum()) for fronts in assigned)
        if duration < best:
            best, chosen = duration, assigned
        heaviest = subtrees[0][1] if subtrees else -1
        below = children[child_start[heaviest] : child_start[heaviest + 1]] if subtrees else children[:0]
        below = below[below >= n_leaves]
        if not below.size:
            break
        heappop(subtrees)
        of_top += float(work[heaviest] - work[below].sum())
        for front in below.tolist():
            heappush(subtrees, (-float(work[front]), front))
    part = np.full(len(parent), -1, dtype=np.int64)
    for number, fronts in enumerate(chosen):
        part[fronts] = number
    for front in range(len(parent) - 1, n_leaves - 1, -1):
        if part[front] < 0 and parent[front] >= 0:
            part[front] = part[parent[front]]
    return part


def _assigned(subtrees: list[tuple[float, int]], n_parts: int) -> list[list[int]]:
    """Subtrees for each part: the heaviest first, each to the part that has least."""
    load = [0.0] * n_parts
    fronts: list[list[int]] = [[] for _ in range(n_parts)]
    for negative_work, front in sorted(subtrees):
        least = load.index(min(load))
        fronts[least].append(front)
        load[least] -= negative_work
    return fronts


def _work_of_subtrees(layout: PanelLayout) -> FloatArray:
    """Operations of each front and all below it, (f,)."""
    work = front_operations(layout.pivots.astype(np.float64), layout.rows.astype(np.float64))
    work = work + 20.0 * (layout.pivots + layout.rows) ** 2
    parent, n_leaves = layout.tree.parent, layout.tree.n_leaves
    leaves = np.flatnonzero(parent[:n_leaves] >= 0)
    np.add.at(work, parent[leaves], work[leaves])
    for front in range(n_leaves, len(parent)):
        if parent[front] >= 0:
            work[parent[front]] += work[front]
    return np.asarray(work)


def _depths(parent: IntArray) -> IntArray:
    depth = np.zeros(len(parent), dtype=np.int64)
    above = parent.tolist()
    for front in range(len(parent) - 1, -1, -1):
        if above[front] >= 0:
            depth[front] = depth[above[front]] + 1
    return depth


def _stack_updates(
    group: IntArray, parent: IntArray, depth: IntArray, squares: IntArray, update: IntArray, base: int
) -> int:
    """Places of the updates of one group of fronts from base on; the end of its memory."""
    inside = set(group.tolist())
    used, peak = [0, 0], [0, 0]
    lowest: dict[int, int] = {}
    for front in group.tolist():
        own = int(depth[front]) % 2
        update[front] = used[own]
        used[own] += int(squares[front])
        peak[own] = max(peak[own], used[own])
        if front in lowest:
            used[1 - own] = lowest.pop(front)
        above = int(parent[front])
        if above in inside:
            lowest.setdefault(above, int(update[front]))
    update[group] += base + np.where(depth[group] % 2 == 1, peak[0], 0)
    return base + sum(peak)


def _stack_outers(group: IntArray, parent: IntArray, squares: IntArray, outer: IntArray, base: int) -> int:
    """Places of Z₂₂ of one group of fronts from base on; the end of its memory."""
    inside = set(group.tolist())
    end = base
    for front in group[::-1].tolist():
        above = int(parent[front])
        outer[front] = outer[above] + squares[above] if above in inside else base
        end = max(end, int(outer[front] + squares[front]))
    return end
