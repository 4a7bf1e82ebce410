"""The inverse of a factored matrix on the pattern of its factor.

From the root to the leaves, with Z the inverse and W = L₂₁ L₁₁⁻¹ of a front, Z₂₂ known from its
parent:

    Z₂₁ = −Z₂₂ W,      Z₁₁ = (L₁₁ L₁₁ᵀ)⁻¹ − Wᵀ Z₂₁

Hence the covariances of all unknowns that are coupled, in the matrix or by the elimination,
without the whole inverse.

References
----------
Takahashi, K., Fagan, J., Chin, M.-S. (1973): Formation of a sparse bus impedance matrix and its
    application to short circuit study. PICA 8, 63-69.
Erisman, A. M., Tinney, W. F. (1975): On computing certain elements of the inverse of a sparse
    matrix. CACM 18, 177-179.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.linalg import blas, lapack

from splinebba_cli.core.estimation.blas_threads import fronts_with_threads, one_thread
from splinebba_cli.core.estimation.block_matrix import FloatArray, IntArray
from splinebba_cli.core.estimation.compiled_fronts import inverse_kernels
from splinebba_cli.core.estimation.panel_layout import PanelLayout

if TYPE_CHECKING:
    from splinebba_cli.core.estimation.block_cholesky import Factor


def select_inverse(factor: Factor) -> SelectedInverse:
    """The inverse on the pattern of a factor, front by front; leaves follow when they are asked for."""
    symbolic = factor.symbolic
    inverse = np.empty(symbolic.factor_entries)
    kernels = inverse_kernels(symbolic.structure.n_unknowns)
    if kernels is None:
        _invert_fronts(factor, inverse)
    else:
        symbolic.compiled.invert(kernels, factor.panel, inverse)
    return SelectedInverse(factor, inverse)


def _invert_fronts(factor: Factor, inverse: FloatArray) -> None:
    """Z₁₁ and Z₂₁ of all fronts but for leaves that are coupled with others."""
    symbolic = factor.symbolic
    for batch in symbolic.batches:
        if not batch.n_pieces:
            batch.invert(factor.panel, batch.inverses(factor.panel), inverse)
    fronts, parents = symbolic.fronts, symbolic.layout.tree.parent.tolist()
    waiting = np.bincount(symbolic.layout.tree.parent[fronts.start :] + 1, minlength=len(parents) + 1)[
        1:
    ].tolist()
    remaining: dict[int, FloatArray] = {}
    for front in fronts_with_threads(reversed(fronts), symbolic.unknowns_of_fronts):
        above = parents[front]
        outer = np.zeros((0, 0))
        if above >= 0:
            parent_outer = remaining[above]
            outer = symbolic.targets[front].take(*symbolic.panels(inverse, above), parent_outer)
            waiting[above] -= 1
            if waiting[above] == 0:
                del remaining[above]
        if waiting[front]:
            remaining[front] = outer
        panels = symbolic.panels(factor.panel, front)
        _invert_front(*panels, outer, *symbolic.panels(inverse, front))


def _invert_front(
    top: FloatArray, below: FloatArray, outer: FloatArray, z_top: FloatArray, z_below: FloatArray
) -> None:
    """Z₁₁ and Z₂₁ of a front from L₁₁, L₂₁ and Z₂₂; of square blocks the lower triangles."""
    z_top[...] = top
    lapack.dpotri(z_top, lower=1, overwrite_c=1)
    if len(below):
        w = blas.dtrsm(1.0, top, below, side=1, lower=1, trans_a=0)
        blas.dsymm(-1.0, outer, w, beta=0.0, c=z_below, side=0, lower=1, overwrite_c=1)
        blas.dgemm(-1.0, w, z_below, beta=1.0, c=z_top, trans_a=1, overwrite_c=1)


@dataclass(frozen=True, eq=False)
class SelectedInverse:
    """Blocks of an inverse.

    Attributes
    ----------
    factor : Factor
    upper : (factor_entries,) float
        Z₁₁ and Z₂₁ of every front but for leaves that are coupled with others.
    """

    factor: Factor
    upper: FloatArray

    @property
    def layout(self) -> PanelLayout:
        """Places of the entries."""
        return self.factor.symbolic.layout

    @cached_property
    def panel(self) -> FloatArray:
        """Z₁₁ and Z₂₁ of every front, (factor_entries,).

        Those of leaves that are coupled with others are computed when this is first asked for.
        """
        symbolic = self.factor.symbolic
        kernels = inverse_kernels(symbolic.structure.n_unknowns)
        if kernels is not None:
            symbolic.compiled.invert_leaves(kernels, self.factor.panel, self.upper)
            return self.upper
        with one_thread():
            for batch, inverses in zip(symbolic.batches, self.factor.leaf_inverses, strict=True):
                if batch.n_pieces:
                    batch.invert(self.factor.panel, inverses, self.upper)
        return self.upper

    def _gather(self, rows: IntArray, cols: IntArray) -> FloatArray:
        """Blocks of equal shape, (k, si, sj)."""
        places = self.layout.entries(rows, cols)
        leaves_end = int(self.layout.offsets[self.layout.tree.n_coupled])
        return (self.panel if places.size and places.min() < leaves_end else self.upper)[places]

    @cached_property
    def values(self) -> FloatArray:
        """The inverse on the pattern of the structure, (structure.n_entries,).

        Aligned with structure.offsets, like the values of a BlockMatrix.
        """
        symbolic = self.factor.symbolic
        kernels = inverse_kernels(symbolic.structure.n_unknowns)
        if kernels is None:
            return self.panel[self.layout.structure_entries]
        return symbolic.compiled.get(kernels, self.panel)

    def diagonal(self) -> FloatArray:
        """Diagonal of the inverse, (N,)."""
        diagonal = np.empty(len(self.layout.permutation))
        diagonal[self.layout.permutation] = self.panel[self.layout.diagonal_entries]
        return diagonal

    def blocks(self, rows: npt.ArrayLike, cols: npt.ArrayLike) -> FloatArray | list[FloatArray]:
        """Blocks of the inverse.

        Parameters
        ----------
        rows, cols : (k,) int
            Pairs of nodes, in either orientation.

        Returns
        -------
        (k, si, sj) float if all blocks have one shape, otherwise a list of k arrays

        Raises
        ------
        PairNotInPattern
            If a pair is not coupled in the factor.  Every pair of the structure is.
        """
        i, j = np.atleast_1d(np.asarray(rows, np.int64)), np.atleast_1d(np.asarray(cols, np.int64))
        sizes = self.layout.structure.sizes
        shape = sizes[i] * (int(sizes.max()) + 1) + sizes[j]
        kinds, kind = np.unique(shape, return_inverse=True)
        if len(kinds) <= 1:
            return self._gather(i, j)
        blocks: list[FloatArray] = [np.empty(0)] * len(i)
        for number in range(len(kinds)):
            chosen = np.flatnonzero(kind == number)
            gathered = self._gather(i[chosen], j[chosen])
            for place, block in zip(chosen.tolist(), gathered, strict=True):
                blocks[place] = block
        return blocks

    def window(self, node_lists: npt.ArrayLike) -> FloatArray:
        """Covariances of small groups of nodes, many groups at once.

        Parameters
        ----------
        node_lists : (k, w) int
            Groups of w nodes, all coupled in the factor; nodes in one column have equal size.

        Returns
        -------
        (k, S, S) float, symmetric; S unknowns of one group, in the order of its nodes

        Raises
        ------
        PairNotInPattern
            If two nodes of a group are not coupled in the factor.
        ValueError
            If the sizes in a column differ.
        """
        nodes = np.atleast_2d(np.asarray(node_lists, dtype=np.int64))
        size = self.layout.structure.sizes[nodes]
        if np.any(size != size[:1]):
            raise ValueError("all groups of a window need nodes of equal sizes")
        ends = np.cumsum(size[0]) if len(size) else np.zeros(nodes.shape[1], dtype=np.int64)
        spans = [slice(int(e - s), int(e)) for e, s in zip(ends, size[0] if len(size) else ends, strict=True)]
        total = int(ends[-1]) if len(ends) else 0
        window = np.empty((len(nodes), total, total))
        for a, span_a in enumerate(spans):
            for b in range(a, len(spans)):
                block = self._gather(nodes[:, a], nodes[:, b])
                window[:, span_a, spans[b]] = block
                window[:, spans[b], span_a] = block.transpose(0, 2, 1)
        return window
