"""Rows of a table sorted into groups, and batches of groups padded to equal length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray

CHUNK_ENTRIES = 150_000  # of a batch: what stays in the cache


@dataclass(frozen=True)
class RowGroups:
    """Rows sorted into groups; the row number `count_rows` stands for a zero row (padding)."""

    representative: IntArray  # (G,) one row of every group
    order: IntArray  # (k,) rows, group by group
    starts: IntArray  # (G + 1,)

    @classmethod
    def of(cls, keys: IntArray) -> RowGroups:
        """Group rows by key, (k,)."""
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        first = (
            np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
            if len(keys)
            else np.zeros(0, int)
        )
        return cls(order[first], order, np.concatenate([first, [len(keys)]]).astype(np.int64))

    def batches(self, row_entries: int | IntArray) -> Iterator[tuple[IntArray, IntArray]]:
        """Groups of similar length with their padded rows: (groups (g,), rows (g, L)); padding is row k.

        Parameters
        ----------
        row_entries : numbers that are worked with for every row; (G,) where they differ, which then also are similar
        """
        counts, entries = np.diff(self.starts), np.broadcast_to(row_entries, len(self.starts) - 1)
        span = int(counts.max(initial=0)) + 1
        keys = np.ceil(np.log2(np.maximum(entries, 1))).astype(np.int64) * span + counts
        by_count = np.argsort(keys, kind="stable")
        keys, position = keys[by_count], 0
        while position < len(by_count):
            shortest = int(counts[by_count[position]])
            similar = keys[position] - shortest + min(shortest + max(1, shortest // 4), span - 1)
            limit = int(np.searchsorted(keys, similar, side="right"))
            longest = int(counts[by_count[limit - 1]])
            widest = int(entries[by_count[position:limit]].max())
            limit = min(limit, position + max(1, CHUNK_ENTRIES // max(1, longest * widest)))
            groups = by_count[position:limit]
            longest = int(counts[groups].max())
            place = self.starts[groups][:, None] + np.arange(longest)
            inside = np.arange(longest) < counts[groups][:, None]
            rows = np.where(inside, self.order[np.minimum(place, len(self.order) - 1)], len(self.order))
            yield groups, rows
            position = limit

    def gram(self, rows: FloatArray) -> FloatArray:
        """J'J of every group of rows J (k, p), (G, p, p)."""
        width = rows.shape[1]
        padded = np.concatenate([rows, np.zeros((1, width))])
        out = np.empty((len(self.starts) - 1, width, width))
        for groups, members in self.batches(width):
            block = padded[members]
            out[groups] = np.matmul(block.transpose(0, 2, 1), block)
        return out


def split_by(keys: IntArray, count: int | None = None) -> list[IntArray]:
    """Rows (ascending) of every key: of 0 .. count - 1, or of the keys that occur, in ascending order."""
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    if count is None:
        return np.split(order, np.flatnonzero(ordered[1:] != ordered[:-1]) + 1) if len(keys) else []
    bounds = np.searchsorted(ordered, np.arange(count + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(count)]
