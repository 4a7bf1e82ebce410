"""Leaves of equal shape, eliminated together.

For each leaf, with V = L₂₁ and the inverse X of its L₁₁:

    L₁₁ L₁₁ᵀ = A₁₁,    V = A₂₁ Xᵀ,    −V Vᵀ goes straight to the places of its rows in the fronts above,

and of the inverse, with W = V X and Z₂₂ from the same places:

    Z₂₁ = −Z₂₂ W,      Z₁₁ = Xᵀ X − Wᵀ Z₂₁

All leaves of one shape lie one behind the other in the panel, so that a batch is a view of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array

from splinebba_cli.core.estimation.block_matrix import FloatArray, IntArray
from splinebba_cli.core.estimation.extend_add import RowPlaces
from splinebba_cli.core.estimation.panel_layout import PanelLayout

BATCH = 256
"""Leaves at a time, so that what is computed of them stays in the cache."""


@dataclass(frozen=True, eq=False)
class LeafBatch:
    """Consecutive leaves of one shape.

    Attributes
    ----------
    layout : PanelLayout
    first, end : int
        The fronts first .. end - 1.
    rows : (k, r) int
        Their rows among all unknowns in the order of elimination.
    step : int
        Rows come in pieces of so many, none of which reaches from one node into the next; m = r / step.
    """

    layout: PanelLayout
    first: int
    end: int
    rows: IntArray
    step: int

    @property
    def n_pieces(self) -> int:
        """Pieces m of the rows of a leaf."""
        return int(self.rows.shape[1]) // self.step

    @property
    def n_pivots(self) -> int:
        """Pivots of each leaf."""
        return int(self.layout.pivots[self.first])

    @property
    def pivots(self) -> slice:
        """Pivots of all leaves of the batch among the unknowns in the order of elimination."""
        unknown, first = self.layout.unknown, self.layout.tree.first
        return slice(int(unknown[first[self.first]]), int(unknown[first[self.end]]))

    def panels(self, flat: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Views of all leaves: A₁₁, or what replaces it, (k, n, n), and A₂₁ transposed, (k, n, r).

        A₁₁ has its lower triangle in the upper one of the view (Fortran order).
        """
        n, (k, r) = self.n_pivots, self.rows.shape
        start = int(self.layout.offsets[self.first])
        both = flat[start : start + k * n * (n + r)].reshape(k, n * (n + r))
        return both[:, : n * n].reshape(k, n, n), both[:, n * n :].reshape(k, n, r)

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray, IntArray, IntArray]:
        """Pairs a ≥ b of the m pieces, (p,); first entry of the block of each pair and its column step, (k, p)."""
        a, b = np.tril_indices(self.n_pieces)
        first, tree = self.rows[:, :: self.step], self.layout.tree
        node = np.searchsorted(self.layout.unknown, first, side="right") - 1
        within = first - self.layout.unknown[node]
        low, high = tree.order[node[:, b].ravel()], tree.order[node[:, a].ravel()]
        start, leading = (x.reshape(len(first), -1) for x in self.layout.block_starts(low, high))
        return a, b, start + within[:, b] * leading + within[:, a], leading

    @cached_property
    def _sums(self) -> tuple[csr_array, IntArray]:
        """Where −V Vᵀ goes, block by block.

        Returns
        -------
        sums : (q, k m²) of ones
            Which blocks (leaf, a, b) of V Vᵀ go to the same place.
        place : (q, s²) int
            The places in the panel, row by row of a block.
        """
        k, m, s = len(self.rows), self.n_pieces, self.step
        a, b, start, step = self._pairs
        order = np.argsort(start.ravel(), kind="stable")
        start, step = start.ravel()[order], step.ravel()[order]
        first = np.flatnonzero(np.concatenate([[True], start[1:] != start[:-1]]))
        block = (np.arange(k)[:, None] * m**2 + b * m + a).ravel()[order]
        ones, bounds = np.ones(len(block)), np.append(first, len(block))
        sums = csr_array((ones, block, bounds), shape=(len(first), k * m**2))
        col, row = np.repeat(np.arange(s), s), np.tile(np.arange(s), s)
        return sums, start[first][:, None] + step[first][:, None] * col + row

    @cached_property
    def _sums_of_rows(self) -> tuple[csr_array, IntArray]:
        """Which of the k r rows belong to the same unknown, (q, k r) of ones, and these unknowns, (q,)."""
        rows = self.rows.ravel()
        order = np.argsort(rows, kind="stable")
        first = np.flatnonzero(np.concatenate([[True], np.diff(rows[order]) != 0]))
        bounds = np.append(first, len(rows))
        return csr_array((np.ones(len(rows)), order, bounds), shape=(len(first), len(rows))), rows[order][
            first
        ]

    def _outer(self, selected: FloatArray) -> FloatArray:
        """Z₂₂ of all leaves, (k, r, r)."""
        k, m, s = len(self.rows), self.n_pieces, self.step
        outer = np.empty((k, m, s, m, s))
        a, b, start, step = self._pairs
        row, col = np.arange(s)[:, None], np.arange(s)
        for pair, (i, j) in enumerate(zip(a.tolist(), b.tolist(), strict=True)):
            low, high = (np.minimum(row, col), np.maximum(row, col)) if i == j else (col, row)
            block = selected[start[:, pair, None, None] + step[:, pair, None, None] * low + high]
            outer[:, i, :, j, :] = block
            outer[:, j, :, i, :] = block.transpose(0, 2, 1)
        return outer.reshape(k, m * s, m * s)

    def eliminate(self, panel: FloatArray) -> FloatArray | None:
        """Factor the leaves in place.

        Returns
        -------
        (q, s²) float, or None where a pivot is not positive
            V Vᵀ of all leaves, summed where they go to one place.
        """
        top, below = self.panels(panel)
        try:
            lower = np.asarray(np.linalg.cholesky(top.transpose(0, 2, 1)), dtype=np.float64)
        except np.linalg.LinAlgError:
            return None
        top[...] = lower.transpose(0, 2, 1)
        k, m, s = len(self.rows), self.n_pieces, self.step
        if m == 0:
            return np.zeros((0, 0))
        below[...] = np.matmul(inverse_triangles(lower), below)
        square = np.matmul(below.transpose(0, 2, 1), below).reshape(k, m, s, m, s)
        return np.asarray(self._sums[0] @ square.transpose(0, 1, 3, 2, 4).reshape(-1, s * s))

    def add(self, update: FloatArray, panel: FloatArray) -> None:
        """Add −V Vᵀ to the fronts above."""
        if update.size:
            panel[self._sums[1]] -= update

    def inverses(self, panel: FloatArray) -> FloatArray:
        """Inverses X of the factors L₁₁, (k, n, n), lower triangular."""
        return inverse_triangles(self.panels(panel)[0].transpose(0, 2, 1))

    def forward(self, x: FloatArray, panel: FloatArray, inverses: FloatArray) -> None:
        """x₁ ← L₁₁⁻¹ x₁,  x₂ ← x₂ − L₂₁ x₁  in place."""
        _, below = self.panels(panel)
        pivots = np.matmul(inverses, self._pivots_of(x))
        x[self.pivots] = pivots.reshape(-1, x.shape[1])
        if self.rows.shape[1]:
            sums, place = self._sums_of_rows
            x[place] -= sums @ np.matmul(below.transpose(0, 2, 1), pivots).reshape(-1, x.shape[1])

    def backward(self, x: FloatArray, panel: FloatArray, inverses: FloatArray) -> None:
        """x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂)  in place."""
        pivots = self._pivots_of(x)
        if self.rows.shape[1]:
            pivots = pivots - np.matmul(self.panels(panel)[1], x[self.rows])
        pivots = np.matmul(inverses.transpose(0, 2, 1), pivots)
        x[self.pivots] = pivots.reshape(-1, x.shape[1])

    def invert(self, panel: FloatArray, inverses: FloatArray, selected: FloatArray) -> None:
        """Z₁₁ and Z₂₁ into the selected inverse, which has those of the fronts above."""
        z_top, z_below = self.panels(selected)
        np.matmul(inverses.transpose(0, 2, 1), inverses, out=z_top)
        if self.rows.shape[1]:
            w = np.matmul(inverses.transpose(0, 2, 1), self.panels(panel)[1])
            np.matmul(w, self._outer(selected), out=z_below)
            np.negative(z_below, out=z_below)
            z_top -= np.matmul(w, z_below.transpose(0, 2, 1))

    def _pivots_of(self, x: FloatArray) -> FloatArray:
        return x[self.pivots].reshape(self.end - self.first, self.n_pivots, x.shape[1])


def leaf_batches(layout: PanelLayout, places: RowPlaces) -> list[LeafBatch]:
    """The leaves of a layout, shape by shape."""
    tree, k = layout.tree, layout.tree.n_leaves
    sizes = layout.structure.sizes[tree.order[tree.row_positions]]
    step, coupled = np.ones(k, dtype=np.int64), np.flatnonzero(layout.rows[:k])
    if coupled.size:
        step[coupled] = np.gcd.reduceat(sizes[: tree.row_start[k]], tree.row_start[coupled])
    shape = np.stack([layout.pivots[:k], layout.rows[:k], step])
    changes = np.flatnonzero((shape[:, 1:] != shape[:, :-1]).any(axis=0)) + 1
    bounds = np.unique(np.concatenate([np.arange(0, k, BATCH), changes, [k]])).tolist()
    batches = []
    for a, b in pairwise(bounds):
        rows = places.unknown[places.start[a] : places.start[b]].reshape(b - a, -1)
        batches.append(LeafBatch(layout, a, b, rows, int(step[a])))
    return batches


def inverse_triangles(lower: FloatArray) -> FloatArray:
    """Inverses of lower triangular matrices, (k, n, n), row by row for all at once.

    x_jj = 1 / l_jj,    x_jm = −x_jj Σ_i l_ji x_im   (m ≤ i < j)
    """
    part = np.ascontiguousarray(lower.transpose(1, 2, 0))
    x = np.zeros_like(part)
    for j in range(len(x)):
        x[j, j] = 1.0 / part[j, j]
        x[j, :j] = np.einsum("ik,imk->mk", part[j, :j], x[:j, :j]) * -x[j, j]
    return np.ascontiguousarray(x.transpose(2, 0, 1))
