"""Which image points the fragments so far explain."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, IntArray

ROUNDS = 3  # from chain to chain, to images that are not compared with the reference image
LEAST_SHARE = 0.5  # of the links of a point that must lead to a fragment


class ExplainedPoints:
    """Marks of chain points, set stretch by stretch."""

    def __init__(self, chains: TracedChains, labels: LabelledPoints) -> None:
        self.taken: BoolArray = np.zeros(len(chains), dtype=bool)
        self._chains, self._labels = chains, labels
        self._begin = np.searchsorted(labels.link_point, np.arange(len(chains) + 1))
        self._nearest = np.rint(labels.link_place).astype(np.int64)
        self._by_place = np.argsort(self._nearest, kind="stable")
        self._place_begin = np.searchsorted(self._nearest[self._by_place], np.arange(len(chains) + 1))

    def links(self, first: int, last: int) -> slice:
        """The links of points first to last - 1."""
        return slice(int(self._begin[first]), int(self._begin[last]))

    def free_links(self, first: int, last: int) -> IntArray:
        """Number of links to points that are still free, of points first to last - 1."""
        rows = self.links(first, last)
        free = ~self.taken[self._nearest[rows]]
        return np.bincount(self._labels.link_point[rows][free] - first, minlength=last - first)

    def take(self, first: int, last: int) -> None:
        """Mark the points of a stretch, those between its links, and those whose links mostly lead to them."""
        rows = self.links(first, last)
        place = self._labels.link_place[rows]
        piece = self._chains.piece[place.astype(np.int64)]
        order = np.argsort(piece, kind="stable")
        piece, place = piece[order], place[order]
        new = np.flatnonzero(np.diff(piece, prepend=-1))
        added = [np.arange(first, last)]
        if len(new):
            low, high = np.minimum.reduceat(place, new), np.maximum.reduceat(place, new)
            added += [np.arange(int(a), int(np.ceil(b)) + 1) for a, b in zip(low, high, strict=True)]
        self._spread(np.concatenate(added))

    def _spread(self, points: IntArray) -> None:
        """Mark points, and those of further images that are linked to them."""
        own = np.unique(points)
        self.taken[own] = True
        for _ in range(ROUNDS):
            count = self._place_begin[own + 1] - self._place_begin[own]
            within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
            linking = self._labels.link_point[
                self._by_place[np.repeat(self._place_begin[own], count) + within]
            ]
            point, number = np.unique(linking[~self.taken[linking]], return_counts=True)
            every = self._begin[point + 1] - self._begin[point]
            own = point[number >= np.maximum(LEAST_SHARE * every, 1)]
            if not len(own):
                break
            self.taken[own] = True
