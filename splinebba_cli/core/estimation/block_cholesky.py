"""Cholesky factorisation of symmetric block-sparse matrices, front by front.

    A + diag(d) = L Lᵀ

Each front assembles the matrix entries of its pivots and the updates of the fronts below it, and
eliminates:

    L₁₁ L₁₁ᵀ = A₁₁,    L₂₁ = A₂₁ L₁₁⁻ᵀ,    update for the parent: U − L₂₁ L₂₁ᵀ

All three are dense (LAPACK potrf, BLAS trsm and syrk).  Leaves (`leaf_nodes`) come first and in batches; where the
matrix is large, compiled kernels do all of it (`compiled_fronts`).  `analyse` depends on the pattern only and
is done once for an adjustment; `SymbolicFactor.factorize` is repeated in every iteration.

References
----------
Liu, J. W. H. (1992): The multifrontal method for sparse matrix solution: theory and practice.
    SIAM Review 34, 82-109.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import blas, lapack

from splinebba_cli.core.estimation.blas_threads import fronts_with_threads, one_thread
from splinebba_cli.core.estimation.block_matrix import BlockStructure, FloatArray
from splinebba_cli.core.estimation.compiled_fronts import FEW, CompiledFronts, factor_kernels
from splinebba_cli.core.estimation.extend_add import RowPlaces, UpdateTarget, row_places, update_target
from splinebba_cli.core.estimation.fronts import (
    COMPILED,
    PLAIN,
    build_fronts,
    front_operations,
    with_leaves,
)
from splinebba_cli.core.estimation.leaf_batches import LeafBatch, leaf_batches
from splinebba_cli.core.estimation.leaf_nodes import find_leaves, no_leaves, without_leaves
from splinebba_cli.core.estimation.ordering import checked_positions, global_nodes, nested_dissection
from splinebba_cli.core.estimation.panel_layout import PanelLayout
from splinebba_cli.core.estimation.schedule import Schedule, schedule
from splinebba_cli.core.threads import in_threads

if TYPE_CHECKING:
    from splinebba_cli.core.estimation.selected_inverse import SelectedInverse

_log = logging.getLogger(__name__)

SINGLE_FRONT = 300
"""Up to so many unknowns are eliminated in one front."""
LONG_TO_ORDER = 20_000
"""Of more unknowns the ordering is told as a stage of its own."""
PART_UNKNOWNS = 60
"""Parts of so many unknowns are not divided further; merging fronts decides the rest."""


class NotPositiveDefinite(ArithmeticError):
    """A pivot is not positive, or too small against the diagonal it came from.

    Attributes
    ----------
    node, unknown_in_node : int
        The unknown, in the numbering of the structure, at which the elimination fails.
    ratio : float
        Pivot / diagonal: what the others leave of its weight.  NaN where it was not computed.
    """

    def __init__(self, node: int, unknown_in_node: int, ratio: float) -> None:
        super().__init__(
            f"unknown {unknown_in_node} of node {node} is not determined: pivot / diagonal = {ratio:.3g}"
        )
        self.node = node
        self.unknown_in_node = unknown_in_node
        self.ratio = ratio

    def __reduce__(self) -> tuple[type[NotPositiveDefinite], tuple[int, int, float]]:
        return type(self), (self.node, self.unknown_in_node, self.ratio)


def analyse(structure: BlockStructure, positions: npt.ArrayLike | None = None) -> SymbolicFactor:
    """Order a pattern and find the pattern of its factor.

    Parameters
    ----------
    structure : BlockStructure
    positions : (n, 2) or (n, 3) float, or None
        Where each node lies, any unit; rows of NaN for global nodes, which are eliminated last.

    Returns
    -------
    SymbolicFactor
    """
    level = logging.INFO if structure.n_unknowns > LONG_TO_ORDER else logging.DEBUG
    _log.log(level, "ordering of %d unknowns", structure.n_unknowns)
    place = checked_positions(positions, structure.n_nodes)
    everywhere = global_nodes(structure, place)
    if structure.n_unknowns <= SINGLE_FRONT:
        leaves, part = no_leaves(), SINGLE_FRONT
    else:
        leaves, part = find_leaves(structure, everywhere), PART_UNKNOWNS
    rest, nodes = without_leaves(structure, leaves)
    costs = PLAIN if factor_kernels(structure.n_unknowns) is None else COMPILED
    dissection = nested_dissection(rest, place[nodes], part, everywhere[nodes])
    tree = build_fronts(rest, dissection, costs)
    layout = PanelLayout.of_tree(structure, with_leaves(structure, leaves, tree, nodes))
    return SymbolicFactor(structure, layout, row_places(layout))


@dataclass(frozen=True, eq=False)
class SymbolicFactor:
    """Everything about a factor that depends on the pattern only.

    Attributes
    ----------
    structure : BlockStructure
    layout : PanelLayout
        Fronts and the places of their entries.
    places : RowPlaces
        Where each front's update goes in its parent.
    """

    structure: BlockStructure
    layout: PanelLayout
    places: RowPlaces

    @property
    def n_fronts(self) -> int:
        """Number of fronts."""
        return len(self.layout.pivots)

    @property
    def fronts(self) -> range:
        """Fronts that are no leaves, in the order of elimination."""
        return range(self.layout.tree.n_leaves, self.n_fronts)

    @cached_property
    def batches(self) -> list[LeafBatch]:
        """The leaves, shape by shape."""
        return leaf_batches(self.layout, self.places)

    @cached_property
    def targets(self) -> dict[int, UpdateTarget]:
        """Where the update of each front that is no leaf goes."""
        return {front: update_target(self.layout, self.places, front) for front in self.fronts}

    @property
    def factor_entries(self) -> int:
        """Entries of the factor that are stored, computed zeros included."""
        return self.layout.n_entries

    @property
    def flops(self) -> float:
        """Floating-point operations of one factorisation."""
        n, r = self.layout.pivots.astype(np.float64), self.layout.rows.astype(np.float64)
        return float(front_operations(n, r).sum())

    @cached_property
    def order(self) -> Schedule:
        """Where updates wait, all fronts one after the other."""
        return schedule(self.layout, 1)

    @cached_property
    def compiled(self) -> CompiledFronts:
        """The same for compiled kernels."""
        return CompiledFronts.of(self.layout, self.places)

    @cached_property
    def unknowns_of_fronts(self) -> list[int]:
        """Pivots and rows of each front together."""
        return list(map(int, self.layout.pivots + self.layout.rows))

    def panels(self, flat: FloatArray, front: int) -> tuple[FloatArray, FloatArray]:
        """Views (n, n) and (r, n) of one front in a flat array, Fortran order."""
        n, r = int(self.layout.pivots[front]), int(self.layout.rows[front])
        start = int(self.layout.offsets[front])
        middle, end = start + n * n, start + n * (n + r)
        top = flat[start:middle].reshape((n, n), order="F")
        return top, flat[middle:end].reshape((r, n), order="F")

    def factorize(
        self,
        values: FloatArray,
        damping: FloatArray | None = None,
        pivot_tolerance: float = 0.0,
    ) -> Factor:
        """Factor of the matrix with these values.

        Parameters
        ----------
        values : (structure.n_entries,) float
            Values of a BlockMatrix of the analysed structure.
        damping : (N,) float, optional
            Added to the diagonal.
        pivot_tolerance : float
            A pivot below pivot_tolerance × (diagonal with damping) counts as failed.  The ratio
            pivot / diagonal is 1 − R², R the multiple correlation (in A) of the unknown with all
            that are eliminated before it.

        Raises
        ------
        NotPositiveDefinite
            Names the first unknown whose pivot fails.
        ValueError
            If values or damping have the wrong length.
        """
        layout, n = self.layout, self.structure.n_unknowns
        if np.shape(values) != (self.structure.n_entries,):
            raise ValueError(f"{self.structure.n_entries} values expected, got {np.shape(values)}")
        if damping is not None and np.shape(damping) != (n,):
            raise ValueError(f"damping for {n} unknowns expected, got {np.shape(damping)}")
        kernels, failed = factor_kernels(n), None
        panel = self._assembled(kernels, values, damping)
        diagonal = panel[layout.diagonal_entries]
        if kernels is None:
            failed = self._eliminate(panel)
        elif not self.compiled.eliminate(kernels, panel):
            panel = self._assembled(None, values, damping)
            failed = self._eliminate(panel)  # the plain way says where
        pivots = panel[layout.diagonal_entries[:failed]] ** 2
        small = np.flatnonzero(~(pivots >= pivot_tolerance * diagonal[: len(pivots)]))
        if small.size:
            raise self._failure(int(small[0]), float(pivots[small[0]] / diagonal[small[0]]))
        if failed is not None:
            raise self._failure(failed, float("nan"))
        return Factor(self, panel)

    def _assembled(self, kernels: Any, values: FloatArray, damping: FloatArray | None) -> FloatArray:
        """The matrix in the places of its factor, (factor_entries,)."""
        layout = self.layout
        panel = np.zeros(layout.n_entries)
        if kernels is None:
            panel[layout.structure_entries] = values
        else:
            self.compiled.put(kernels, np.ascontiguousarray(values), panel)
        if damping is not None:
            panel[layout.diagonal_entries] += damping[layout.permutation]
        return panel

    def _failure(self, eliminated: int, ratio: float) -> NotPositiveDefinite:
        unknown = int(self.layout.permutation[eliminated])
        node = int(np.searchsorted(self.structure.starts, unknown, side="right")) - 1
        return NotPositiveDefinite(node, unknown - int(self.structure.starts[node]), ratio)

    def _eliminate(self, panel: FloatArray) -> int | None:
        """Replace the assembled matrix by its factor; the place of a failed pivot, or None."""
        order, work = self.order, np.empty(self.order.update_size)
        with one_thread():
            updates_of_leaves = in_threads(lambda batch: batch.eliminate(panel), self.batches)
        for batch, update in zip(self.batches, updates_of_leaves, strict=True):
            if update is None:
                return self._failed_leaf(panel, batch)
            batch.add(update, panel)
        for front in fronts_with_threads(self.fronts, self.unknowns_of_fronts):
            top, below = self.panels(panel, front)
            update = self._waiting(work, front)
            update[...] = 0.0
            for child in order.below(front):
                self.targets[child].add(self._waiting(work, child), top, below, update)
            _, info = lapack.dpotrf(top, lower=1, clean=0, overwrite_a=1)
            if info != 0:
                return int(self.layout.unknown[self.layout.tree.first[front]] + info - 1)
            if len(below):
                blas.dtrsm(1.0, top, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                blas.dsyrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1)
        return None

    def _waiting(self, work: FloatArray, front: int) -> FloatArray:
        """The update of a front in the working memory, (r, r), Fortran order."""
        start, r = int(self.order.update[front]), int(self.layout.rows[front])
        return work[start : start + r * r].reshape((r, r), order="F")

    def _failed_leaf(self, panel: FloatArray, batch: LeafBatch) -> int:
        """The place of the first failed pivot of a batch; the leaves before it are factored."""
        for front in range(batch.first, batch.end):
            _, info = lapack.dpotrf(self.panels(panel, front)[0], lower=1, clean=0, overwrite_a=1)
            if info != 0:
                return int(self.layout.unknown[self.layout.tree.first[front]] + info - 1)
        raise AssertionError("a batch fails where none of its leaves does")


@dataclass(frozen=True, eq=False)
class Factor:
    """The Cholesky factor of a matrix.

    Attributes
    ----------
    symbolic : SymbolicFactor
    panel : (factor_entries,) float
        L₁₁ and L₂₁ of every front, see `PanelLayout`.
    """

    symbolic: SymbolicFactor
    panel: FloatArray

    @property
    def log_determinant(self) -> float:
        """log det(A + diag(d)) = 2 Σ log Lᵢᵢ."""
        return float(2.0 * np.log(self.panel[self.symbolic.layout.diagonal_entries]).sum())

    def solve(self, rhs: FloatArray) -> FloatArray:
        """Solution x of (A + diag(d)) x = b.

        Parameters
        ----------
        rhs : (N,) or (N, k) float

        Returns
        -------
        float, the shape of rhs

        Raises
        ------
        ValueError
            If rhs has not N rows.
        """
        symbolic = self.symbolic
        permutation = symbolic.layout.permutation
        right = np.asarray(rhs, dtype=np.float64)
        if right.ndim not in (1, 2) or len(right) != len(permutation):
            raise ValueError(f"{len(permutation)} rows expected, got an array of shape {right.shape}")
        if right.size == 0:
            return right.copy()
        x = np.ascontiguousarray(right.reshape(len(right), -1)[permutation])
        kernels = factor_kernels(len(x)) if x.shape[1] <= FEW else None
        if kernels is None:
            self._solve_plain(x)
        else:
            for column in range(x.shape[1]):
                one = np.ascontiguousarray(x[:, column])
                symbolic.compiled.solve(kernels, self.panel, one)
                x[:, column] = one
        solution = np.empty_like(x)
        solution[permutation] = x
        return solution.reshape(right.shape)

    def _solve_plain(self, x: FloatArray) -> None:
        """Solve in place, x (N, k) in the order of elimination."""
        symbolic = self.symbolic
        fronts, batches = symbolic.fronts, symbolic.batches
        with one_thread():
            for batch, inverses in zip(batches, self.leaf_inverses, strict=True):
                batch.forward(x, self.panel, inverses)
        for front in fronts_with_threads(fronts, symbolic.unknowns_of_fronts):
            self._forward(x, front)
        for front in fronts_with_threads(reversed(fronts), symbolic.unknowns_of_fronts):
            self._backward(x, front)
        with one_thread():
            for batch, inverses in zip(batches, self.leaf_inverses, strict=True):
                batch.backward(x, self.panel, inverses)

    @cached_property
    def leaf_inverses(self) -> list[FloatArray]:
        """Inverses of L₁₁ of all leaves, batch by batch."""
        return in_threads(lambda batch: batch.inverses(self.panel), self.symbolic.batches)

    def _forward(self, x: FloatArray, front: int) -> None:
        """x₁ ← L₁₁⁻¹ x₁,  x₂ ← x₂ − L₂₁ x₁  in place."""
        top, below = self.symbolic.panels(self.panel, front)
        target = self.symbolic.targets[front]
        pivots = x[target.pivots]
        blas.dtrsm(1.0, top, pivots.T, side=1, lower=1, trans_a=1, overwrite_b=1)
        if below.shape[0]:
            x[target.rows] -= below @ pivots

    def _backward(self, x: FloatArray, front: int) -> None:
        """x₁ ← L₁₁⁻ᵀ (x₁ − L₂₁ᵀ x₂)  in place."""
        top, below = self.symbolic.panels(self.panel, front)
        target = self.symbolic.targets[front]
        pivots = x[target.pivots]
        if below.shape[0]:
            pivots -= below.T @ x[target.rows]
        blas.dtrsm(1.0, top, pivots.T, side=1, lower=1, trans_a=0, overwrite_b=1)

    def selected_inverse(self) -> SelectedInverse:
        """The inverse on the pattern of the factor."""
        from splinebba_cli.core.estimation.selected_inverse import select_inverse

        return select_inverse(self)
