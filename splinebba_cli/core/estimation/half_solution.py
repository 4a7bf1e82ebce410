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
    touched = np.flatnonzero(reach.any(axis=1)).tolist()
    for front in fronts_with_threads(touched, symbolic.unknowns_of_fronts):
        reached = np.flatnonzero(reach[front])
        everyone = len(reached) == columns.shape[1]
        target = symbolic.targets[front]
        top, below = symbolic.panels(factor.panel, front)
        y = x[target.pivots] if everyone else x[target.pivots, reached]
        y = np.ascontiguousarray(y)
        blas.dtrsm(1.0, top, y.T, side=1, lower=1, trans_a=1, overwrite_b=1)
        if below.shape[0] and everyone:
            x[target.rows] -= below @ y
        elif below.shape[0]:
            rows = target.rows if isinstance(target.rows, slice) else target.rows[:, None]
            x[rows, reached] -= below @ y
        yield reached, y


def _reach(factor: Factor, row: IntArray, column: IntArray, count: int) -> BoolArray:
    """Which columns reach which fronts, (fronts, k); `row` in the order of elimination."""
    layout = factor.symbolic.layout
    ends = np.cumsum(layout.pivots)
    reach = np.zeros((len(ends), count), dtype=bool)
    reach[np.searchsorted(ends, row, side="right"), column] = True
    for front, parent in enumerate(layout.tree.parent.tolist()):
        if parent >= 0:
            reach[parent] |= reach[front]
    return reach
