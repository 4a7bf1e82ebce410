"""Elimination order by nested dissection: by position where it serves, else by the graph.

    part of the graph  =  first | separator | second,   eliminated as first, second, separator

No edge connects the two sides, so that no block between them is filled; each side is divided
again until it is small.

All parts of one level are divided together with array operations.  A part is put into a line
along each coordinate axis and along its own length in the graph (breadth-first distance from two
opposite ends); the line whose middle cuts least is taken, and the lightest separator near its
middle is found by `vertex_separators`.  Curves are heavier than images, so separators come out as
images, and a curve goes to the side where its images are.

References
----------
George, A. (1973): Nested dissection of a regular finite element mesh.
    SIAM J. Numer. Anal. 10, 345-363.
Heath, M. T., Raghavan, P. (1995): A Cartesian parallel nested dissection algorithm.
    SIAM J. Matrix Anal. 16, 235-253.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from splinebba_cli.core.estimation.block_matrix import (
    BlockStructure,
    FloatArray,
    IntArray,
)
from splinebba_cli.core.estimation.vertex_separator import (
    FIRST,
    SECOND,
    SEPARATOR,
    vertex_separators,
)

BoolArray = npt.NDArray[np.bool_]

ROOT = 0
BAND = 0.15
"""Share of the unknowns on either side of the middle among which a separator is looked for."""


@dataclass(frozen=True, eq=False)
class Dissection:
    """Tree of parts; the nodes of a part are eliminated after those of all parts below it.

    Attributes
    ----------
    part : (n,) int
        Part of each node.  Part 0, the root, holds the global nodes.
    parent : (p,) int
        Parent of each part, smaller than the part itself; -1 for the root.
    """

    part: IntArray
    parent: IntArray


@dataclass(frozen=True, eq=False)
class _Level:
    """The parts to be divided at one level, their nodes and edges numbered from 0."""

    weights: IntArray  # (m,)
    group: IntArray  # (m,) part of each node, ascending
    n_groups: int
    edges: IntArray  # (2, e)
    positions: FloatArray  # (m, d)


def nested_dissection(
    structure: BlockStructure,
    positions: npt.ArrayLike | None,
    leaf_unknowns: int,
    everywhere: BoolArray | None = None,
) -> Dissection:
    """Divide the nodes of a structure into a tree of parts.

    Parameters
    ----------
    structure : BlockStructure
    positions : (n, d) float or None
        Any unit.  Nodes without position (NaN) are global and go to the root, unless no node has
        one.
    leaf_unknowns : int
        Parts of at most so many unknowns are not divided.
    everywhere : (n,) bool, optional
        Global nodes, beside those that `global_nodes` finds.

    Returns
    -------
    Dissection

    Raises
    ------
    ValueError
        If positions has not one row per node.
    """
    n = structure.n_nodes
    place = checked_positions(positions, n)
    off = structure.rows != structure.cols
    edges = np.stack([structure.rows[off], structure.cols[off]])
    below = ~global_nodes(structure, place)
    if everywhere is not None:
        below &= ~everywhere
    part = np.where(below, 1, ROOT).astype(np.int64)
    parent = [-1, ROOT]
    nodes = np.flatnonzero(below)
    while nodes.size:
        nodes, edges = _undivided(nodes, edges, part, structure.sizes, leaf_unknowns)
        if nodes.size:
            nodes = _divide(nodes, edges, part, parent, structure.sizes, place)
    return Dissection(part, np.array(parent, dtype=np.int64))


def checked_positions(positions: npt.ArrayLike | None, n: int) -> FloatArray:
    """Positions as an array, (n, d); without columns where no node has one."""
    if positions is None:
        return np.zeros((n, 0))
    place = np.asarray(positions, dtype=np.float64)
    if place.ndim != 2 or len(place) != n:
        raise ValueError(f"positions of {n} nodes expected, got an array of shape {place.shape}")
    if n and not np.isfinite(place).all(axis=1).any():
        return np.zeros((n, 0))
    return place


def global_nodes(structure: BlockStructure, place: FloatArray) -> BoolArray:
    """Nodes without position, and nodes coupled with more than 16 and more than half of all."""
    n, off = len(place), structure.rows != structure.cols
    degree = np.bincount(structure.rows[off], minlength=n) + np.bincount(structure.cols[off], minlength=n)
    return np.asarray(~np.isfinite(place).all(axis=1) | (degree > max(16, n // 2)))


def _undivided(
    nodes: IntArray, edges: IntArray, part: IntArray, sizes: IntArray, leaf_unknowns: int
) -> tuple[IntArray, IntArray]:
    """Nodes of the parts that are still too large, sorted by part, and the edges inside them."""
    nodes = nodes[np.argsort(part[nodes], kind="stable")]
    weight = np.bincount(part[nodes], sizes[nodes], int(part.max()) + 1)
    nodes = nodes[weight[part[nodes]] > leaf_unknowns]
    active = np.zeros(len(part), dtype=bool)
    active[nodes] = True
    u, v = edges
    return nodes, edges[:, active[u] & active[v] & (part[u] == part[v])]


def _divide(
    nodes: IntArray,
    edges: IntArray,
    part: IntArray,
    parent: list[int],
    sizes: IntArray,
    place: FloatArray,
) -> IntArray:
    """Divide every part once; changes part and parent and returns the nodes of the new parts."""
    old, group = np.unique(part[nodes], return_inverse=True)
    local = np.full(len(part), -1, dtype=np.int64)
    local[nodes] = np.arange(len(nodes))
    level = _Level(sizes[nodes], group, len(old), local[edges], place[nodes])
    side = vertex_separators(level.weights, level.edges, _best_line(level), BAND)
    count = np.bincount(group * 3 + side, minlength=3 * len(old)).reshape(-1, 3)
    divided = (count[:, FIRST] > 0) & (count[:, SECOND] > 0)
    child = len(parent) + 2 * (np.cumsum(divided) - 1)
    parent.extend(np.repeat(old[divided], 2).tolist())
    moves = divided[group] & (side != SEPARATOR)
    part[nodes[moves]] = (child[group] + side)[moves]
    divided_nodes: IntArray = nodes[moves]
    return divided_nodes


def _best_line(level: _Level) -> FloatArray:
    """Place of each node, 0 to 1, in the line of its part whose middle cuts least."""
    lines = [_fractions(level, key) for key in level.positions.T]
    lines.append(_fractions(level, _graph_line(level)))
    cut = np.stack([_cut_weight(level, line) for line in lines])
    best = np.argmin(cut, axis=0)
    chosen: FloatArray = np.stack(lines)[best[level.group], np.arange(len(level.group))]
    return chosen


def _fractions(level: _Level, key: npt.NDArray[np.generic]) -> FloatArray:
    """Share of its part's unknowns before the middle of each node, nodes sorted by key."""
    order = np.lexsort((key, level.group))
    weight = level.weights[order].astype(np.float64)
    total = np.bincount(level.group, level.weights, level.n_groups)
    before = np.cumsum(total) - total
    fraction = np.empty(len(order))
    group = level.group[order]
    fraction[order] = (np.cumsum(weight) - 0.5 * weight - before[group]) / total[group]
    return fraction


def _cut_weight(level: _Level, fraction: FloatArray) -> FloatArray:
    """Unknowns on the lighter side of the cut through the middle of each part."""
    u, v = level.edges
    first = fraction < 0.5
    at_cut = np.zeros(len(first), dtype=bool)
    crossing = first[u] != first[v]
    at_cut[u[crossing]] = True
    at_cut[v[crossing]] = True
    sides = [
        np.bincount(level.group, level.weights * (at_cut & which), level.n_groups)
        for which in (first, ~first)
    ]
    return np.minimum(*sides)


def _graph_line(level: _Level) -> IntArray:
    """Rank of each node from one end of its component to the other, component by component."""
    from scipy.sparse.csgraph import connected_components  # not at start-up: it takes its time

    n = len(level.group)
    u, v = level.edges
    ones = np.ones(2 * len(u), dtype=np.int8)
    graph = csr_array((ones, (np.concatenate([u, v]), np.concatenate([v, u]))), shape=(n, n))
    component = connected_components(graph, directed=False)[1].astype(np.int64)
    _, seeds = np.unique(component, return_index=True)
    for _ in range(2):
        one_end = _breadth_first_rank(graph, seeds)
        seeds = _last_of_each(component, one_end)
    other_end = _breadth_first_rank(graph, seeds)
    rank = np.empty(n, dtype=np.int64)
    rank[np.lexsort((one_end - other_end, component))] = np.arange(n)
    return rank


def _breadth_first_rank(graph: csr_array, seeds: IntArray) -> IntArray:
    """Rank of each node in a breadth-first search from all seeds at once."""
    from scipy.sparse.csgraph import breadth_first_order

    n = graph.shape[0]
    indptr = np.append(graph.indptr, graph.indptr[-1] + len(seeds))
    indices = np.concatenate([graph.indices, seeds.astype(graph.indices.dtype)])
    ones = np.ones(len(indices), dtype=np.int8)
    seeded = csr_array((ones, indices, indptr), shape=(n + 1, n + 1))
    order = breadth_first_order(seeded, n, return_predecessors=False)[1:]
    rank = np.empty(n, dtype=np.int64)
    rank[order] = np.arange(n)
    return rank


def _last_of_each(component: IntArray, rank: IntArray) -> IntArray:
    """The node of highest rank in each component."""
    order = np.lexsort((rank, component))
    last = np.append(np.flatnonzero(np.diff(component[order])), len(order) - 1)
    ends: IntArray = order[last]
    return ends
