"""Chains of measured curve points whose locations arc lengths and tangents tie together.

A measured point without either has a location of its own.  Points with arc lengths between them form a chain: the
normal matrix of its locations is tridiagonal.  A point with a tangent alone is a chain of one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import ArcLengths, BoolArray, IntArray, Network

NONE = -1


@dataclass(frozen=True)
class Chains:
    """All chains, padded to the longest with -1."""

    points: IntArray  # (G, L) measured curve points in order
    arcs: IntArray  # (G, L - 1) arc length from one point to the next
    tangents: IntArray  # (G, L) tangent observation at each point
    linked: BoolArray  # (n,) whether a measured curve point is in a chain

    @classmethod
    def of(cls, network: Network) -> Chains:
        """Chains of a network.

        Raises
        ------
        ValueError
            If a measured point begins (or ends) two arcs, has two tangents, or arcs close a ring or join points
            of different images or curves.
        """
        count = len(network.curve_observations)
        arc_after, following = _successors(network.arc_lengths, count)
        tangent_of = _unique_owner(network.tangents.point, count, "two tangents at one measured point")
        linked = (arc_after >= 0) | (tangent_of >= 0)
        linked[network.arc_lengths.second] = True
        _require_same_curve(network)
        starts = np.ones(count, dtype=bool)
        starts[network.arc_lengths.second] = False
        current = np.flatnonzero(linked & starts)
        points, arcs = [current], []
        while True:
            arc = np.where(current >= 0, arc_after[current], NONE)
            if not (arc >= 0).any():
                break
            current = np.where(arc >= 0, following[current], NONE)
            points.append(current)
            arcs.append(arc)
        chain_points = np.stack(points, axis=1)
        if np.count_nonzero(chain_points >= 0) != np.count_nonzero(linked):
            raise ValueError("arc lengths close a ring: leave one of them out")
        chain_arcs = np.stack(arcs, axis=1) if arcs else np.zeros((len(chain_points), 0), dtype=np.int64)
        tangents = np.where(chain_points >= 0, tangent_of[chain_points], NONE) if count else chain_points
        return cls(chain_points, chain_arcs, tangents, linked)

    def __len__(self) -> int:
        return len(self.points)

    def select(self, chosen: IntArray | BoolArray, length: int | None = None) -> Chains:
        """Some of the chains, cut to `length` points."""
        arcs = None if length is None else length - 1
        return Chains(
            self.points[chosen, :length],
            self.arcs[chosen, :arcs],
            self.tangents[chosen, :length],
            self.linked,
        )

    def batches(self, entries: int) -> Iterator[Chains]:
        """Chains of similar length together, each batch cut to its longest, with at most `entries` points or so."""
        lengths = np.count_nonzero(self.points >= 0, axis=1)
        order = np.argsort(lengths, kind="stable")
        position = 0
        while position < len(order):
            shortest = lengths[order[position]]
            limit = int(np.searchsorted(lengths[order], 2 * shortest, side="right"))
            longest = int(lengths[order[limit - 1]])
            limit = min(limit, position + max(1, entries // longest))
            rows = order[position:limit]
            yield self.select(rows, int(lengths[rows].max()))
            position = limit


def _successors(arcs: ArcLengths, count: int) -> tuple[IntArray, IntArray]:
    """The arc that begins at each measured point and the point where it ends, -1 where there is none."""
    arc_after = _unique_owner(arcs.first, count, "two arc lengths begin at one measured point")
    _unique_owner(arcs.second, count, "two arc lengths end at one measured point")
    following = np.full(count, NONE)
    following[arcs.first] = arcs.second
    return arc_after, following


def _unique_owner(point: IntArray, count: int, message: str) -> IntArray:
    """Number of the observation that belongs to each measured point, -1 for none."""
    if len(np.unique(point)) != len(point):
        raise ValueError(message)
    owner = np.full(count, NONE)
    owner[point] = np.arange(len(point))
    return owner


def _require_same_curve(network: Network) -> None:
    observed, arcs = network.curve_observations, network.arc_lengths
    for index in (observed.image, observed.curve):
        if (index[arcs.first] != index[arcs.second]).any():
            raise ValueError("an arc length joins points of different images or curves")
