"""Measured curve points in the order of assembly: windows of an image and a block of a curve, in chunks.

    chunk   some blocks with all their windows: as many points as stay in the cache, one unit of work of a thread
    run     windows of a chunk with equally many points, one behind the other: their products are one stacked product

A block is never divided between chunks, so that sums over the windows of a block are sums inside a chunk (but for
nodes that neighbouring blocks of a long curve share).  The division does not depend on the number of threads, nor do
the sums.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.network import IntArray
from splinebba_cli.core.tracks import chunk_size

CHUNK_POINTS = 32_768


@dataclass(frozen=True)
class Run:
    """Windows of equal length."""

    windows: slice
    points: slice
    length: int


@dataclass(frozen=True)
class Chunk:
    """Windows and points that are worked on together; all blocks have nodes of the same sizes."""

    windows: slice
    points: slice
    runs: tuple[Run, ...]


@dataclass(frozen=True)
class CurveWindows:
    """Windows of all measured points on curves of powers."""

    points: IntArray  # (k,) measured points in the order of assembly
    window: IntArray  # (k,) their windows
    image: IntArray  # (G,)
    block: IntArray  # (G,)
    chunks: tuple[Chunk, ...]

    @classmethod
    def of(cls, image: IntArray, block: IntArray, blocks: CurveBlocks) -> CurveWindows:
        """Windows of measured points.

        Parameters
        ----------
        image, block : (n,) of all measured points; points in block -1 are left out
        """
        kind = blocks.kind
        points = np.flatnonzero(block >= 0)
        if not len(points):
            none = np.zeros(0, dtype=np.int64)
            return cls(none, none, none, none, ())
        keys = (kind[block[points]] * len(blocks) + block[points]) * (int(image.max()) + 1) + image[points]
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        starts = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1]))
        counts = np.diff(np.append(starts, len(points)))
        first = points[order[starts]]
        chunk = _chunk_of_windows(kind[block[first]], block[first], counts)
        by_length = np.lexsort((counts, chunk))
        counts = counts[by_length]
        ends = np.cumsum(counts)
        place = np.repeat(starts[by_length] - ends + counts, counts) + np.arange(len(points))
        first = first[by_length]
        return cls(
            points=points[order[place]],
            window=np.repeat(np.arange(len(counts)), counts),
            image=image[first],
            block=block[first],
            chunks=_chunks(chunk[by_length], counts),
        )

    def __len__(self) -> int:
        return len(self.image)


def _chunk_of_windows(kind: IntArray, block: IntArray, counts: IntArray) -> IntArray:
    """Chunk of every window, windows sorted by kind and block."""
    new_kind = np.append(True, kind[1:] != kind[:-1])
    new_block = np.flatnonzero(np.append(True, block[1:] != block[:-1]) | new_kind)
    before = np.cumsum(counts) - counts
    begin = before[np.flatnonzero(new_kind)][np.cumsum(new_kind) - 1]
    size = chunk_size(int(counts.sum()), CHUNK_POINTS)
    part = ((before - begin) // size)[new_block]  # of the block's first window
    new_chunk = np.zeros(len(block), dtype=bool)
    new_chunk[new_block] = np.append(True, part[1:] != part[:-1]) | new_kind[new_block]
    return np.asarray(np.cumsum(new_chunk) - 1)


def _chunks(chunk: IntArray, counts: IntArray) -> tuple[Chunk, ...]:
    """Slices of chunks and runs of windows that are sorted by chunk and length."""
    point = np.concatenate([[0], np.cumsum(counts)])
    begins = np.flatnonzero(np.append(True, (chunk[1:] != chunk[:-1]) | (counts[1:] != counts[:-1])))
    ends = np.append(begins[1:], len(counts))
    runs = [
        Run(slice(a, b), slice(int(point[a]), int(point[b])), int(counts[a]))
        for a, b in zip(begins.tolist(), ends.tolist(), strict=True)
    ]
    first = np.flatnonzero(np.append(True, np.diff(chunk[begins]) != 0)).tolist()
    return tuple(
        Chunk(
            slice(runs[a].windows.start, runs[b - 1].windows.stop),
            slice(runs[a].points.start, runs[b - 1].points.stop),
            tuple(runs[a:b]),
        )
        for a, b in zip(first, [*first[1:], len(runs)], strict=True)
    )
