"""Compiled kernels of the block Cholesky factorisation and of the solution of its triangular systems.

The operations are those of `block_cholesky` and `leaf_batches`.  A front takes the updates of the leaves below it,
then those of the other fronts, and is eliminated.  ``plan`` is the tuple

    pivots, rows, offsets, first, row_start, row_unknown, place, split, child_start, children, update, n_leaves

of `PanelLayout`, `RowPlaces` and `Schedule`; ``first`` is the first pivot of each front among the unknowns.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from splinebba_cli.core.estimation.dense_compiled import (
    arguments,
    divide_transposed,
    factor,
    subtract_square,
)

LARGEST_LEAF = 128


@njit(cache=True, nogil=True)
def put(first, end, blocks, values, panel):
    """Blocks first .. end - 1 to their places; of diagonal blocks the upper triangle means nothing there."""
    offsets, n_rows, n_cols, start, row_step, col_step = blocks
    for b in range(first, end):
        k = offsets[b]
        for i in range(n_rows[b]):
            place = start[b] + i * row_step[b]
            for _ in range(n_cols[b]):
                panel[place] = values[k]
                place += col_step[b]
                k += 1


@njit(cache=True, nogil=True)
def eliminate(fronts, plan, panel, work):
    """Factor fronts and the leaves below them in place; False where a pivot is not positive."""
    pivots, rows, offsets, child_start, children, update, n_leaves = (
        plan[0], plan[1], plan[2], plan[8], plan[9], plan[10], plan[11],
    )  # fmt: skip
    scalars, square = arguments(), np.empty(LARGEST_LEAF**2)
    for front in fronts:
        n, r = pivots[front], rows[front]
        waiting = work[update[front] : update[front] + r * r]
        waiting[:] = 0.0
        top = panel[offsets[front] : offsets[front] + n * n]
        below = panel[offsets[front] + n * n : offsets[front] + n * (n + r)]
        for child in children[child_start[front] : child_start[front + 1]]:
            if child < n_leaves:
                if not eliminate_leaf(child, plan, panel):
                    return False
                _add_leaf(scalars, child, plan, panel, top, below, waiting, n, r, square)
            else:
                size = rows[child]
                _add(
                    child, plan, work[update[child] : update[child] + size * size], top, below, waiting, n, r
                )
        if factor(scalars, top, n) != 0:
            return False
        if r > 0:
            divide_transposed(scalars, top, below, r, n)
            subtract_square(scalars, waiting, below, r, n)
    return True


@njit(cache=True, nogil=True)
def eliminate_leaf(leaf, plan, panel):
    """L₁₁ and L₂₁ of one leaf in place, column after column; False where a pivot is not positive."""
    n, r, start = plan[0][leaf], plan[1][leaf], plan[2][leaf]
    below = start + n * n
    for j in range(n):
        own = panel[start + j * n + j : start + (j + 1) * n]
        own_below = panel[below + j * r : below + (j + 1) * r]
        for i in range(j):
            factor_ij = panel[start + i * n + j]
            other = panel[start + i * n + j : start + (i + 1) * n]
            for k in range(n - j):
                own[k] -= factor_ij * other[k]
            other_below = panel[below + i * r : below + (i + 1) * r]
            for k in range(r):
                own_below[k] -= factor_ij * other_below[k]
        if not own[0] > 0.0:
            return False
        pivot = np.sqrt(own[0])
        scale = 1.0 / pivot
        own[0] = pivot
        for k in range(1, n - j):
            own[k] *= scale
        for k in range(r):
            own_below[k] *= scale
    return True


@njit(cache=True, nogil=True)
def eliminate_lonely(leaves, plan, panel):
    """Factor leaves that are coupled with nothing; False where a pivot is not positive."""
    for leaf in leaves:  # noqa: SIM110
        if not eliminate_leaf(leaf, plan, panel):
            return False
    return True


@njit(cache=True, nogil=True)
def _add_leaf(scalars, leaf, plan, panel, top, below, waiting, n, r, square):
    """Add −V Vᵀ of a leaf to its parent."""
    own, size = plan[0][leaf], plan[1][leaf]
    start = plan[2][leaf] + own * own
    square[: size * size] = 0.0
    subtract_square(scalars, square, panel[start : start + size * own], size, own)
    _add(leaf, plan, square, top, below, waiting, n, r)


@njit(cache=True, nogil=True)
def _add(child, plan, child_update, top, below, waiting, n, r):
    """Add the update of a front to its parent, column after column."""
    size, row_start, split = plan[1][child], plan[4][child], plan[7][child]
    place = plan[6][row_start : row_start + size]
    for j in range(size):
        _add_column(child_update[j * size : (j + 1) * size], j, size, split, place, top, below, waiting, n, r)


@njit(cache=True, nogil=True)
def _add_column(column, j, size, split, place, top, below, waiting, n, r):
    """Add one column of an update, from its diagonal on, where its rows are in the parent."""
    if j < split:
        of_top, of_below = top[place[j] * n :], below[place[j] * r :]
        for k in range(j, split):
            of_top[place[k]] += column[k]
        for k in range(split, size):
            of_below[place[k] - n] += column[k]
    else:
        of_waiting = waiting[(place[j] - n) * r :]
        for k in range(j, size):
            of_waiting[place[k] - n] += column[k]


@njit(cache=True, nogil=True)
def forward(fronts, plan, panel, x, change):
    """x₁ ← L₁₁⁻¹ (x₁ + change₁),  change₂ ← change₂ − L₂₁ x₁, of the leaves below each front and of the front."""
    child_start, children, n_leaves = plan[8], plan[9], plan[11]
    largest = 1
    for front in fronts:
        largest = max(largest, plan[1][front])
    below = np.empty(max(largest, LARGEST_LEAF))
    for front in fronts:
        for child in children[child_start[front] : child_start[front + 1]]:
            if child < n_leaves:
                _forward(child, plan, panel, x, change, below)
        _forward(front, plan, panel, x, change, below)


@njit(cache=True, nogil=True)
def forward_lonely(leaves, plan, panel, x):
    """x₁ ← L₁₁⁻¹ x₁ of leaves that are coupled with nothing."""
    nothing = np.zeros_like(x)
    for leaf in leaves:
        _forward(leaf, plan, panel, x, nothing, nothing)


@njit(cache=True, nogil=True)
def _forward(front, plan, panel, x, change, below):
    n, r, start, first, row_start = (
        plan[0][front],
        plan[1][front],
        plan[2][front],
        plan[3][front],
        plan[4][front],
    )
    below[:r] = 0.0
    own, more = x[first : first + n], change[first : first + n]
    for j in range(n):
        column = panel[start + j * n : start + (j + 1) * n]
        value = (own[j] + more[j]) / column[j]
        own[j] = value
        for k in range(j + 1, n):
            more[k] -= value * column[k]
        of_below = panel[start + n * n + j * r : start + n * n + (j + 1) * r]
        for k in range(r):
            below[k] += value * of_below[k]
    unknown = plan[5][row_start : row_start + r]
    for k in range(r):
        change[unknown[k]] -= below[k]


@njit(cache=True, nogil=True)
def backward(fronts, plan, panel, x):
    """x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂), of each front and of the leaves below it, from the last front to the first."""
    child_start, children, n_leaves = plan[8], plan[9], plan[11]
    largest = 1
    for front in fronts:
        largest = max(largest, plan[1][front])
    below = np.empty(max(largest, LARGEST_LEAF))
    for front in fronts[::-1]:
        _backward(front, plan, panel, x, below)
        for child in children[child_start[front] : child_start[front + 1]]:
            if child < n_leaves:
                _backward(child, plan, panel, x, below)


@njit(cache=True, nogil=True)
def backward_lonely(leaves, plan, panel, x):
    """x₁ ← L₁₁⁻ᵀ x₁ of leaves that are coupled with nothing."""
    for leaf in leaves:
        _backward(leaf, plan, panel, x, x)


@njit(cache=True, nogil=True)
def _backward(front, plan, panel, x, below):
    n, r, start, first, row_start = (
        plan[0][front],
        plan[1][front],
        plan[2][front],
        plan[3][front],
        plan[4][front],
    )
    unknown = plan[5][row_start : row_start + r]
    for k in range(r):
        below[k] = x[unknown[k]]
    own = x[first : first + n]
    for j in range(n - 1, -1, -1):
        of_below = panel[start + n * n + j * r : start + n * n + (j + 1) * r]
        column = panel[start + j * n + j + 1 : start + (j + 1) * n]
        value = own[j] - _dot(of_below, below[:r]) - _dot(column, own[j + 1 :])
        own[j] = value / panel[start + j * n + j]


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _dot(a, b):
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total
