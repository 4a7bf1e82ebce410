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
    row_nodes : (k, m) int
        Positions of the nodes that they couple with, ascending; all of one size s, r = m s.
    """

    layout: PanelLayout
    first: int
    end: int
    row_nodes: IntArray

    @property
    def row_size(self) -> int:
        """Unknowns s of each of the nodes that the leaves couple with; 0 without any."""
        m = self.row_nodes.shape[1]
        return int(self.layout.rows[self.first]) // m if m else 0

    @cached_property
    def rows(self) -> IntArray:
        """Rows of all leaves among all unknowns in the order of elimination, (k, r)."""
        first = self.layout.unknown[self.row_nodes]
        return np.asarray((first[:, :, None] + np.arange(self.row_size)).reshape(len(first), -1))

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
        """Pairs a ≥ b of the m nodes, (p,); first entry of the block of each pair and its column step, (k, p)."""
        a, b = np.tril_indices(self.row_nodes.shape[1])
        order = self.layout.tree.order
        low, high = order[self.row_nodes[:, b]], order[self.row_nodes[:, a]]
        start, step = self.layout.block_starts(low.ravel(), high.ravel())
        return a, b, start.reshape(low.shape), step.reshape(low.shape)

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
        (k, m), s = self.row_nodes.shape, self.row_size
        a, b, start, step = self._pairs
        order = np.argsort(start.ravel(), kind="stable")
        start, step = start.ravel()[order], step.ravel()[order]
        first = np.flatnonzero(np.concatenate([[True], start[1:] != start[:-1]]))
        block = (np.arange(k)[:, None] * m**2 + b * m + a).ravel()[order]
        ones, bounds = np.ones(len(block)), np.append(first, len(block))
        sums = csr_array((ones, block, bounds), shape=(len(first), k * m**2))
        col, row = np.repeat(np.arange(s), s), np.tile(np.arange(s), s)
        return sums, start[first][:, None] + step[first][:, None] * col + row

    def _outer(self, selected: FloatArray) -> FloatArray:
        """Z₂₂ of all leaves, (k, r, r)."""
        (k, m), s = self.row_nodes.shape, self.row_size
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
            lower = np.linalg.cholesky(top.transpose(0, 2, 1))
        except np.linalg.LinAlgError:
            return None
        top[...] = lower.transpose(0, 2, 1)
        (k, m), s = self.row_nodes.shape, self.row_size
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
            np.subtract.at(x, self.rows, np.matmul(below.transpose(0, 2, 1), pivots))

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


def leaf_batches(layout: PanelLayout) -> list[LeafBatch]:
    """The leaves of a layout, shape by shape."""
    tree, k = layout.tree, layout.tree.n_leaves
    shape = np.stack([layout.pivots[:k], layout.rows[:k], np.diff(tree.row_start[: k + 1])])
    changes = np.flatnonzero((shape[:, 1:] != shape[:, :-1]).any(axis=0)) + 1
    bounds = np.unique(np.concatenate([np.arange(0, k, BATCH), changes, [k]])).tolist()
    nodes = [tree.row_positions[tree.row_start[a] : tree.row_start[b]] for a, b in pairwise(bounds)]
    return [
        LeafBatch(layout, a, b, of_batch.reshape(b - a, -1))
        for (a, b), of_batch in zip(pairwise(bounds), nodes, strict=True)
    ]


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
