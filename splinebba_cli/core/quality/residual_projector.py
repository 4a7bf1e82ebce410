"""What a bias of the observations does to the residuals, without any dense matrix of their size.

Whitened: v = -R e with R = I - A Q A' (symmetric, idempotent), e the errors of the observations.  Of directions C in
the space of the observations this gives R C and the small matrices C'R C.  With points eliminated,

    b_r = A_r'C - N_rx H^-1 A_x'C,    C'A Q A'C = (A_x'C)' H^-1 A_x'C + b_r' S^-1 b_r

S the reduced normal matrix of which the factor is at hand.  (Baarda 1968; Teunissen 2000, Testing theory)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from splinebba_cli.core.estimation.block_cholesky import Factor
from splinebba_cli.core.estimation.curve_chunks import CurveEquations
from splinebba_cli.core.estimation.gauss_markov import Solution
from splinebba_cli.core.estimation.half_solution import gram, gram_band
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.sparse_design import SparseDesign, sparse_design
from splinebba_cli.core.network import FloatArray, IntArray

BLOCK_ENTRIES = 16_000_000  # of the right-hand sides that are solved together
MOST_TOGETHER = 512
BATCH_ENTRIES = 2_000_000  # of directions that are projected together
DENSE = 0.2  # share of entries from which directions are multiplied as dense ones
WORK = 5e9  # floating-point operations that one family of tests may take


@dataclass(frozen=True)
class ResidualProjector:
    """R = I - A Q A' of a solution, by its factor."""

    assembler: Assembler
    solution: Solution
    curve: CurveEquations | None = None  # where they are at hand

    @cached_property
    def design(self) -> SparseDesign:
        """The rows, in whose order directions are given."""
        at = self.solution.linearization
        return sparse_design(self.assembler, at, self.curve or CurveEquations.at(self.assembler, at))

    @property
    def factor(self) -> Factor:
        """Undamped factor of the reduced system."""
        if self.solution.factor is None:
            raise ValueError("no factor: the estimation did not converge")
        return self.solution.factor

    @property
    def affordable(self) -> int:
        """Number of directions that one family of tests may have."""
        each = 4.0 * self.factor.symbolic.factor_entries + 4.0 * self.design.reduced.nnz
        return int(WORK / max(each, 1.0))

    def grams(self, blocks: list[sparse.csc_array]) -> Iterator[tuple[FloatArray, FloatArray]]:
        """C'C and C'R C of every one of many small blocks of directions; several of them are solved together."""
        width = min(MOST_TOGETHER, max(1, BLOCK_ENTRIES // max(1, self.design.reduced.shape[1])))
        batch: list[sparse.csc_array] = []
        size, entries = 0, 0
        for block in blocks:
            if batch and (size + block.shape[1] > width or entries + block.nnz > BATCH_ENTRIES):
                yield from self._batch(batch)
                batch, size, entries = [], 0, 0
            batch.append(block)
            size, entries = size + block.shape[1], entries + block.nnz
        if batch:
            yield from self._batch(batch)

    def cofactors(self, unknowns: IntArray) -> FloatArray:
        """Q of some reduced unknowns (k,), (k, k)."""
        k = len(unknowns)
        shape = (self.design.reduced.shape[1], k)
        return gram(self.factor, sparse.csc_array((np.ones(k), unknowns, np.arange(k + 1)), shape=shape))

    def project(self, errors: FloatArray) -> FloatArray:
        """R E of errors (rows, k), (rows, k)."""
        design, inverse = self.design, self._point_inverse
        over_points = design.points.T @ errors
        side = design.over_unknowns(errors)
        if design.points.nnz:
            side -= design.coupling @ (inverse @ over_points)
        step = self.factor.solve(side)
        points = inverse @ (over_points - design.coupling.T @ step)
        shown = design.on_rows(step)
        np.subtract(errors, shown, out=shown)
        if design.points.nnz:
            shown -= design.points @ points
        return shown

    def _batch(self, blocks: list[sparse.csc_array]) -> Iterator[tuple[FloatArray, FloatArray]]:
        together = side_by_side(blocks)
        width = np.array([block.shape[1] for block in blocks])
        widest = int(width.max())
        side, of_points = self._reduced_sides(together)
        inner = band_of(sparse.csc_array(together.T @ together), widest)
        rest = (
            inner
            - band_of(of_points, widest)
            - gram_band(self.factor, side, np.repeat(np.arange(len(blocks)), width))
        )
        begin = 0
        for block in blocks:
            own = np.arange(begin, begin + block.shape[1])
            begin += len(own)
            place = np.abs(own[:, None] - own), np.minimum(own[:, None], own)
            yield inner[place], rest[place]

    def _reduced_sides(self, directions: sparse.csc_array) -> tuple[sparse.csc_array, sparse.csc_array]:
        """b_r and (A_x'C)' H^-1 A_x'C of directions, (N, k) and (k, k)."""
        dense = directions.nnz > DENSE * directions.shape[0] * directions.shape[1]
        side = self.design.reduced.T @ (directions.toarray() if dense else directions)
        if not self.design.points.nnz:
            return sparse.csc_array(side), sparse.csc_array((directions.shape[1], directions.shape[1]))
        over_points = sparse.csc_array(self.design.points.T @ directions)
        back = self._point_inverse @ over_points
        return sparse.csc_array(side - self.design.coupling @ back), sparse.csc_array(over_points.T @ back)

    @cached_property
    def _point_inverse(self) -> sparse.csr_array:
        """H^-1 of all points, block diagonal, (3 n, 3 n)."""
        eliminated = self.solution.eliminated
        if eliminated is None:
            raise ValueError("no eliminated points")
        count = len(eliminated.inverse)
        if not count:
            return sparse.csr_array((0, 0))
        blocks = (eliminated.inverse, np.arange(count), np.arange(count + 1))
        return sparse.csr_array(sparse.bsr_array(blocks, shape=(3 * count, 3 * count)))


def side_by_side(blocks: list[sparse.csc_array]) -> sparse.csc_array:
    """The columns of all blocks."""
    if len(blocks) == 1:
        return blocks[0]
    begins = np.cumsum([0, *(block.nnz for block in blocks)])
    pointers = [block.indptr[1:] + begin for block, begin in zip(blocks, begins[:-1].tolist(), strict=True)]
    parts = (
        np.concatenate([block.data for block in blocks]),
        np.concatenate([block.indices for block in blocks]),
        np.concatenate([[0], *pointers]),
    )
    return sparse.csc_array(parts, shape=(blocks[0].shape[0], sum(block.shape[1] for block in blocks)))


def band_of(matrix: sparse.csc_array, width: int) -> FloatArray:
    """Diagonals 0 .. width - 1 of a symmetric matrix (k, k), (width, k): entry (d, i) is that of i and i + d."""
    shape = (width, matrix.shape[1])
    column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    distance = column - matrix.indices
    chosen = (distance >= 0) & (distance < width)
    place = distance[chosen] * matrix.shape[1] + matrix.indices[chosen]
    return np.asarray(
        np.bincount(place, matrix.data[chosen], minlength=shape[0] * shape[1]).reshape(shape),
        dtype=np.float64,
    )
