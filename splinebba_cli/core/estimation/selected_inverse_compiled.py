"""Compiled kernels of the selected inverse; the operations are those of `selected_inverse` and `leaf_batches`.

``plan`` is the tuple

    pivots, rows, offsets, parent, row_start, place, split, child_start, children, outer, n_leaves

of `PanelLayout`, `RowPlaces` and `Schedule`.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from splinebba_cli.core.estimation.dense_compiled import (
    arguments,
    divide,
    inverse,
    subtract_product,
    times_symmetric,
)


@njit(cache=True, nogil=True)
def get(first, end, blocks, diagonal, panel, values):
    """Blocks first .. end - 1 from their places, diagonal blocks from the lower triangle."""
    offsets, n_rows, n_cols, start, row_step, col_step = blocks
    for b in range(first, end):
        k = offsets[b]
        for i in range(n_rows[b]):
            for j in range(n_cols[b]):
                row, col = (max(i, j), min(i, j)) if diagonal[b] else (i, j)
                values[k] = panel[start[b] + row * row_step[b] + col * col_step[b]]
                k += 1


@njit(cache=True, nogil=True)
def invert_fronts(fronts, plan, panel, selected, work):
    """Z₁₁ and Z₂₁ of fronts, from the last to the first; Z₂₂ stays in the working memory."""
    pivots, rows, offsets = plan[0], plan[1], plan[2]
    largest = 1
    for front in fronts:
        largest = max(largest, rows[front] * pivots[front])
    w, scalars = np.empty(largest), arguments()
    for front in fronts[::-1]:
        n, r, start = pivots[front], rows[front], offsets[front]
        z_top = selected[start : start + n * n]
        z_top[:] = panel[start : start + n * n]
        inverse(scalars, z_top, n)
        if r > 0:
            outer = _taken_by_front(front, plan, selected, work)
            w[: r * n] = panel[start + n * n : start + n * (n + r)]
            divide(scalars, panel[start:], w, r, n)
            z_below = selected[start + n * n : start + n * (n + r)]
            times_symmetric(scalars, z_below, outer, w, r, n)
            subtract_product(scalars, z_top, w, z_below, r, n)


@njit(cache=True, nogil=True)
def take_fronts(fronts, plan, selected, work):
    """Z₂₂ of fronts into the working memory once more."""
    for front in fronts[::-1]:
        if plan[1][front] > 0:
            _taken_by_front(front, plan, selected, work)


@njit(cache=True, nogil=True)
def invert_leaves(fronts, plan, panel, selected, work):
    """Z₁₁ and Z₂₁ of the leaves below fronts; takes Z₂₂ of the fronts once more."""
    child_start, children, n_leaves = plan[7], plan[8], plan[10]
    largest_n, largest_r = 1, 1
    for leaf in range(n_leaves):
        largest_n, largest_r = max(largest_n, plan[0][leaf]), max(largest_r, plan[1][leaf])
    w, outer = np.empty(largest_n * largest_r), np.empty(largest_r * largest_r)
    for front in fronts[::-1]:
        if plan[1][front] > 0:
            _taken_by_front(front, plan, selected, work)
        for child in children[child_start[front] : child_start[front + 1]]:
            if child < n_leaves:
                _take(child, plan, selected, work, outer)
                _invert_leaf(child, plan, panel, selected, w, outer)


@njit(cache=True, nogil=True)
def invert_lonely(leaves, plan, panel, selected):
    """Z₁₁ of leaves that are coupled with nothing."""
    nothing = np.empty(0)
    for leaf in leaves:
        _invert_leaf(leaf, plan, panel, selected, nothing, nothing)


@njit(cache=True, nogil=True)
def _taken_by_front(front, plan, selected, work):
    """Z₂₂ of a front in its place of the working memory, the lower triangle."""
    r, start = plan[1][front], plan[9][front]
    outer = work[start : start + r * r]
    _take(front, plan, selected, work, outer)
    return outer


@njit(cache=True, nogil=True)
def _take(front, plan, selected, work, outer):
    """Lower triangle of the parent's inverse on the rows of a front or leaf."""
    above, r, row_start, split = plan[3][front], plan[1][front], plan[4][front], plan[6][front]
    n_above, r_above, start = plan[0][above], plan[1][above], plan[2][above]
    top = selected[start : start + n_above * n_above]
    below = selected[start + n_above * n_above : start + n_above * (n_above + r_above)]
    remaining = work[plan[9][above] : plan[9][above] + r_above * r_above]
    place = plan[5][row_start : row_start + r]
    for j in range(split):
        of_top, of_below = top[place[j] * n_above :], below[place[j] * r_above :]
        column = outer[j * r : (j + 1) * r]
        for k in range(j, split):
            column[k] = of_top[place[k]]
        for k in range(split, r):
            column[k] = of_below[place[k] - n_above]
    for j in range(split, r):
        of_remaining = remaining[(place[j] - n_above) * r_above :]
        column = outer[j * r : (j + 1) * r]
        for k in range(j, r):
            column[k] = of_remaining[place[k] - n_above]


@njit(cache=True, nogil=True)
def _invert_leaf(leaf, plan, panel, selected, w, outer):
    n, r, start = plan[0][leaf], plan[1][leaf], plan[2][leaf]
    below = start + n * n
    _invert_triangle(panel[start:below], selected[start:below], n)
    for j in range(n):  # W = V X: columns i >= j of V
        own = w[j * r : (j + 1) * r]
        own[:] = 0.0
        for i in range(j, n):
            x_ij = selected[start + j * n + i]
            column = panel[below + i * r : below + (i + 1) * r]
            for k in range(r):
                own[k] += x_ij * column[k]
    for j in range(
        n
    ):  # Xᵀ X column by column; entries below the diagonal of column j need columns of X from j on
        for k in range(j, n):
            total = 0.0
            for i in range(k, n):
                total += selected[start + k * n + i] * selected[start + j * n + i]
            selected[start + j * n + k] = total
    for i in range(r):  # full symmetric Z₂₂
        for k in range(i + 1, r):
            outer[k * r + i] = outer[i * r + k]
    for j in range(n):  # Z₂₁ = −Z₂₂ W
        z = selected[below + j * r : below + (j + 1) * r]
        z[:] = 0.0
        for i in range(r):
            w_ij = w[j * r + i]
            column = outer[i * r : (i + 1) * r]
            for k in range(r):
                z[k] -= w_ij * column[k]
    for j in range(n):
        z = selected[below + j * r : below + (j + 1) * r]
        for k in range(j, n):
            selected[start + j * n + k] -= _dot(w[k * r : (k + 1) * r], z)


@njit(cache=True, nogil=True)
def _invert_triangle(lower, x, n):
    """X = L⁻¹ column by column, lower triangles."""
    for j in range(n):
        x[j * n + j] = 1.0 / lower[j * n + j]
        for k in range(j + 1, n):
            x[j * n + k] = 0.0
        for i in range(j, n):
            if i > j:
                x[j * n + i] /= lower[i * n + i]
            value = x[j * n + i]
            for k in range(i + 1, n):
                x[j * n + k] -= lower[i * n + k] * value


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def _dot(a, b):
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total
