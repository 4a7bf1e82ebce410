"""Products C'S^-1 C of sparse right-hand sides, by forward substitution alone.

    S = L L',   Y = L^-1 C,   C'S^-1 C = Y'Y

The columns that touch few unknowns reach few fronts: those that eliminate these unknowns and the fronts above.  In
every front only the columns that reach it are solved for.  (Gilbert & Peierls 1988: the reach of a sparse right side)
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import sparse
from scipy.linalg import blas

from splinebba_cli.core.estimation.blas_threads import fronts_with_threads
from splinebba_cli.core.estimation.block_cholesky import Factor
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

ALONE = 200
"""Columns for which a leaf of a batch costs as much as a leaf that is worked on alone."""


def gram(factor: Factor, columns: sparse.csc_array) -> FloatArray:
    """C'S^-1 C of columns C (N, k), (k, k)."""
    out = np.zeros((columns.shape[1], columns.shape[1]))
    for reached, y in _forward(factor, columns):
        if len(reached) == len(out):
            out += y.T @ y
        else:
            out[np.ix_(reached, reached)] += y.T @ y
    return out


def gram_band(factor: Factor, columns: sparse.csc_array, block: IntArray) -> FloatArray:
    """C'S^-1 C inside blocks of columns, (widest block, k): entry (d, i) is that of columns i and i + d of one block.

    Parameters
    ----------
    block : (k,) int, ascending: the block of every column
    """
    count = columns.shape[1]
    widest = int(np.bincount(block).max(initial=1))
    out = np.zeros((widest, count))
    together = [np.flatnonzero(block[d:] == block[: count - d]) for d in range(widest)]
    place = np.empty(count, dtype=np.int64)
    for reached, y in _forward(factor, columns):
        out[0, reached] += np.einsum("nk,nk->k", y, y)
        place[:] = -1
        place[reached] = np.arange(len(reached))
        for d in range(1, widest):
            first = together[d]
            first = first[(place[first] >= 0) & (place[first + d] >= 0)]
            if len(first):
                out[d, first] += np.einsum("nk,nk->k", y[:, place[first]], y[:, place[first + d]])
    return out


def _forward(factor: Factor, columns: sparse.csc_array) -> Iterator[tuple[IntArray, FloatArray]]:
    """Of every front that is reached: the columns that reach it (ascending), and their part of Y."""
    symbolic = factor.symbolic
    permutation = symbolic.layout.permutation
    place = np.empty(len(permutation), dtype=np.int64)
    place[permutation] = np.arange(len(permutation))
    column = np.repeat(np.arange(columns.shape[1]), np.diff(columns.indptr))
    row = place[columns.indices]
    x = np.zeros(columns.shape)
    x[row, column] = columns.data
    reach = _reach(factor, row, column, columns.shape[1])
    single: list[int] = []
    for batch, inverses in zip(symbolic.batches, factor.leaf_inverses, strict=True):
        own = reach[batch.first : batch.end]
        if int(own.any(axis=1).sum()) * ALONE > own.size:
            batch.forward(x, factor.panel, inverses)
            yield np.arange(columns.shape[1]), x[batch.pivots]
        else:
            single += (batch.first + np.flatnonzero(own.any(axis=1))).tolist()
    single += (symbolic.fronts.start + np.flatnonzero(reach[symbolic.fronts.start :].any(axis=1))).tolist()
    for front in fronts_with_threads(single, symbolic.unknowns_of_fronts):
        reached = np.flatnonzero(reach[front])
        yield reached, _forward_in_front(factor, front, x, reached)


def _forward_in_front(factor: Factor, front: int, x: FloatArray, reached: IntArray) -> FloatArray:
    """Part of Y in one front, and what it takes from the rows behind, in place."""
    symbolic, layout = factor.symbolic, factor.symbolic.layout
    first, places = layout.unknown[layout.tree.first], symbolic.places
    pivots = slice(int(first[front]), int(first[front + 1]))
    rows = places.unknown[int(places.start[front]) : int(places.start[front + 1])]
    top, below = symbolic.panels(factor.panel, front)
    everyone = len(reached) == x.shape[1]
    y = np.ascontiguousarray(x[pivots] if everyone else x[pivots, reached])
    blas.dtrsm(1.0, top, y.T, side=1, lower=1, trans_a=1, overwrite_b=1)
    if len(rows) and everyone:
        x[rows] -= below @ y
    elif len(rows):
        x[rows[:, None], reached] -= below @ y
    return y


def _reach(factor: Factor, row: IntArray, column: IntArray, count: int) -> BoolArray:
    """Which columns reach which fronts, (fronts, k); `row` in the order of elimination."""
    layout = factor.symbolic.layout
    front_of_row = np.repeat(np.arange(len(layout.pivots)), layout.pivots)
    reach = np.zeros((len(layout.pivots), count), dtype=bool)
    reach[front_of_row[row], column] = True
    for front, parent in enumerate(layout.tree.parent.tolist()):
        if parent >= 0:
            reach[parent] |= reach[front]
    return reach
