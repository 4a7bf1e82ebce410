"""Tracks: all points that one image measures on one curve, curve by curve."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.network import CurveObservations, IntArray

CHUNK_POINTS = 32_768  # that are worked on together: long enough for threads not to wait for each other


@dataclass(frozen=True)
class Tracks:
    """Measured points sorted by curve and image."""

    points: IntArray  # (n,) measured points
    starts: IntArray  # (T + 1,) first place of every track in `points`
    image: IntArray  # (T,)
    curve: IntArray  # (T,)

    @classmethod
    def of(cls, observed: CurveObservations) -> Tracks:
        """Tracks of all measured points."""
        if not len(observed):
            none = np.zeros(0, dtype=np.int64)
            return cls(none, np.zeros(1, dtype=np.int64), none, none)
        keys = observed.curve * (int(observed.image.max()) + 1) + observed.image
        points = np.argsort(keys, kind="stable")
        ordered = keys[points]
        starts = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1]))
        first = points[starts]
        return cls(points, np.append(starts, len(points)), observed.image[first], observed.curve[first])

    def __len__(self) -> int:
        return len(self.image)

    @cached_property
    def of_place(self) -> IntArray:
        """Track of every entry of `points`, (n,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.starts))

    def chunks(self) -> list[slice]:
        """Slices of tracks that are worked on together."""
        return chunks_of(self.starts, chunk_size(len(self.points), CHUNK_POINTS))


def chunk_size(count: int, largest: int) -> int:
    """Points in a chunk of `count` points: an even number of chunks of equal size, but one where it is small."""
    if count <= largest:
        return max(count, 1)
    return -(-count // (2 * -(-count // (2 * largest))))


def chunks_of(starts: IntArray, size: int) -> list[slice]:
    """Slices of groups that begin at `starts` (G + 1,), each of about `size` entries."""
    number = starts[:-1] // size
    ends = np.append(np.flatnonzero(number[1:] != number[:-1]) + 1, len(number))
    begins = np.append(0, ends[:-1])
    return [slice(a, b) for a, b in zip(begins.tolist(), ends.tolist(), strict=True) if b > a]
