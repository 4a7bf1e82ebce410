"""Symmetric block-sparse matrices: which blocks exist, and their values.

    A = Aᵀ,   A[i, j] a dense block of sizes[i] × sizes[j],   stored for i ≤ j only

A node is a group of unknowns (the six of an image, the coefficients of a curve).  The blocks lie
one behind the other in one flat array, each in C order, sorted by row and then by column, so that
whoever assembles normal equations or gathers dispersions works on plain arrays.  Diagonal blocks
are stored whole and must be symmetric.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class PairNotInPattern(KeyError):
    """A block was asked for that the sparsity pattern does not hold.

    Attributes
    ----------
    row, col : int
        The first pair of nodes that is missing.
    """

    def __init__(self, row: int, col: int) -> None:
        super().__init__(f"no block ({row}, {col}) in the pattern")
        self.row = row
        self.col = col

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[type[PairNotInPattern], tuple[int, int]]:
        return type(self), (self.row, self.col)


@dataclass(frozen=True, eq=False)
class BlockStructure:
    """Pattern of a symmetric block-sparse matrix.

    Attributes
    ----------
    sizes : (n,) int
        Unknowns of each node, at least 1.
    rows, cols : (b,) int
        Nodes of each stored block, rows ≤ cols, sorted by (row, col), all n diagonal pairs among
        them.
    offsets : (b + 1,) int
        First entry of each block in the flat array of values.
    starts : (n + 1,) int
        First unknown of each node; starts[n] = N.
    """

    sizes: IntArray
    rows: IntArray
    cols: IntArray
    offsets: IntArray
    starts: IntArray

    @classmethod
    def from_pairs(
        cls, sizes: npt.ArrayLike, pairs_rows: npt.ArrayLike, pairs_cols: npt.ArrayLike
    ) -> BlockStructure:
        """Structure of given pairs of coupled nodes.

        Parameters
        ----------
        sizes : (n,) int
        pairs_rows, pairs_cols : (p,) int
            In either orientation; duplicates are merged, the diagonal is added.

        Raises
        ------
        ValueError
            If a size is below 1 or a pair names a node that does not exist.
        """
        size = np.asarray(sizes, dtype=np.int64).ravel()
        first = np.asarray(pairs_rows, dtype=np.int64).ravel()
        second = np.asarray(pairs_cols, dtype=np.int64).ravel()
        n = len(size)
        if np.any(size < 1):
            raise ValueError("every node needs at least one unknown")
        low, high = np.minimum(first, second), np.maximum(first, second)
        if low.size and (low.min() < 0 or high.max() >= n):
            raise ValueError(f"a pair names a node outside 0..{n - 1}")
        keys = np.unique(np.concatenate([low * n + high, np.arange(n) * (n + 1)]))
        rows, cols = keys // max(n, 1), keys % max(n, 1)
        return cls(size, rows, cols, _cumulative(size[rows] * size[cols]), _cumulative(size))

    @property
    def n_nodes(self) -> int:
        """Number of nodes n."""
        return len(self.sizes)

    @property
    def n_unknowns(self) -> int:
        """Number of unknowns N."""
        return int(self.starts[-1])

    @property
    def n_entries(self) -> int:
        """Length of the flat array of values."""
        return int(self.offsets[-1])

    @cached_property
    def _keys(self) -> IntArray:
        return self.rows * self.n_nodes + self.cols

    def find(self, rows: npt.ArrayLike, cols: npt.ArrayLike) -> IntArray:
        """Numbers of the stored blocks of pairs of nodes.

        Parameters
        ----------
        rows, cols : (k,) int
            In either orientation: the block of (j, i) is the stored block of (i, j), to be
            transposed by the caller.

        Returns
        -------
        (k,) int

        Raises
        ------
        PairNotInPattern
            Names the first pair that is not stored.
        """
        i, j = np.asarray(rows, dtype=np.int64), np.asarray(cols, dtype=np.int64)
        keys = np.minimum(i, j) * self.n_nodes + np.maximum(i, j)
        block = np.minimum(np.searchsorted(self._keys, keys), max(len(self._keys) - 1, 0))
        inside = (np.minimum(i, j) >= 0) & (np.maximum(i, j) < self.n_nodes)
        missing = np.flatnonzero(np.ravel(~inside | (self._keys[block] != keys)))
        if missing.size:
            raise PairNotInPattern(int(i.flat[missing[0]]), int(j.flat[missing[0]]))
        return np.asarray(block, dtype=np.int64)

    def shape_groups(self) -> Iterator[tuple[IntArray, int, int]]:
        """Blocks of one shape at a time: (numbers of the blocks, rows, columns)."""
        shape = self.sizes[self.rows] * (int(self.sizes.max(initial=0)) + 1) + self.sizes[self.cols]
        order = np.argsort(shape, kind="stable")
        ends = np.flatnonzero(np.diff(shape[order])) + 1
        for blocks in np.split(order, ends):
            if blocks.size:
                yield (
                    blocks,
                    int(self.sizes[self.rows[blocks[0]]]),
                    int(self.sizes[self.cols[blocks[0]]]),
                )


@dataclass(frozen=True, eq=False)
class BlockMatrix:
    """A symmetric block-sparse matrix.

    Attributes
    ----------
    structure : BlockStructure
    values : (structure.n_entries,) float
        Block b is values[offsets[b]:offsets[b + 1]] in C order.
    """

    structure: BlockStructure
    values: FloatArray

    def blocks(self, numbers: IntArray) -> FloatArray:
        """Stored blocks of equal shape, (k, si, sj); a copy."""
        s = self.structure
        si, sj = int(s.sizes[s.rows[numbers[0]]]), int(s.sizes[s.cols[numbers[0]]])
        entries = s.offsets[numbers][:, None] + np.arange(si * sj)
        return np.asarray(self.values[entries].reshape(-1, si, sj))

    def diagonal(self) -> FloatArray:
        """Main diagonal, (N,)."""
        s = self.structure
        size = s.sizes
        block = np.repeat(s.offsets[np.flatnonzero(s.rows == s.cols)], size)
        within = np.arange(s.n_unknowns) - np.repeat(s.starts[:-1], size)
        return self.values[block + within * (np.repeat(size, size) + 1)]

    def multiply(self, vector: FloatArray) -> FloatArray:
        """Product A x.

        Parameters
        ----------
        vector : (N,) float

        Returns
        -------
        (N,) float
        """
        s = self.structure
        product = np.zeros(s.n_unknowns)
        for numbers, si, sj in s.shape_groups():
            block = self.blocks(numbers)
            i = s.starts[s.rows[numbers]][:, None] + np.arange(si)
            j = s.starts[s.cols[numbers]][:, None] + np.arange(sj)
            right = np.matmul(block, vector[j][:, :, None])[:, :, 0]
            product += np.bincount(i.ravel(), right.ravel(), s.n_unknowns)
            off = s.rows[numbers] != s.cols[numbers]
            if np.any(off):
                left = np.matmul(vector[i[off]][:, None, :], block[off])[:, 0, :]
                product += np.bincount(j[off].ravel(), left.ravel(), s.n_unknowns)
        return product

    def to_dense(self) -> FloatArray:
        """The whole matrix, (N, N); for tests and small problems."""
        s = self.structure
        dense = np.zeros((s.n_unknowns, s.n_unknowns))
        for numbers, si, sj in s.shape_groups():
            block = self.blocks(numbers)
            i = s.starts[s.rows[numbers]][:, None, None] + np.arange(si)[:, None]
            j = s.starts[s.cols[numbers]][:, None, None] + np.arange(sj)
            dense[i, j] = block
            dense[j, i] = block
        return dense


def _cumulative(counts: IntArray) -> IntArray:
    total = np.zeros(len(counts) + 1, dtype=np.int64)
    np.cumsum(counts, out=total[1:])
    return total
