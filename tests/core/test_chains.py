"""Chains of linked points: order, padding, and what cannot be a chain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.chains import Chains
from splinebba_cli.core.network import ArcLengths, Network, Tangents
from splinebba_cli.simulation.six_image_block import simulate_block


def network(arcs: list[tuple[int, int]], tangents: tuple[int, ...] = ()) -> Network:
    """The six images with arcs between points of the first chain of 30 measured points."""
    made, _ = simulate_block("six-image")
    first, second = np.array(arcs, dtype=np.int64).reshape(-1, 2).T
    count = len(first)
    at = np.array(tangents, dtype=np.int64)
    return replace(
        made,
        arc_lengths=ArcLengths(first, second, np.ones(count), np.ones(count), np.zeros(count, dtype=bool)),
        tangents=Tangents(at, np.zeros(len(at)), np.ones(len(at)), np.zeros(len(at), dtype=bool)),
    )


def test_chains_follow_the_arcs() -> None:
    found = Chains.of(network([(4, 7), (7, 5), (10, 11)], tangents=(5, 20)))
    assert found.points.tolist() == [[4, 7, 5], [10, 11, -1], [20, -1, -1]]
    assert found.arcs.tolist() == [[0, 1], [2, -1], [-1, -1]]
    assert found.tangents.tolist() == [[-1, -1, 0], [-1, -1, -1], [1, -1, -1]]
    assert np.flatnonzero(found.linked).tolist() == [4, 5, 7, 10, 11, 20]


def test_batches_hold_every_chain_once() -> None:
    found = Chains.of(network([(0, 1), (1, 2), (2, 3), (5, 6), (8, 9)], tangents=(12, 13)))
    batches = list(found.batches(4))
    assert len(batches) > 1
    points = np.concatenate([batch.points[batch.points >= 0] for batch in batches])
    assert sorted(points) == [0, 1, 2, 3, 5, 6, 8, 9, 12, 13]


@pytest.mark.parametrize(
    ("arcs", "tangents", "message"),
    [
        ([(0, 1), (0, 2)], (), "two arc lengths begin"),
        ([(0, 2), (1, 2)], (), "two arc lengths end"),
        ([(0, 1), (1, 2), (2, 0)], (), "close a ring"),
        ([(0, 40)], (), "different images or curves"),
        ([], (3, 3), "two tangents"),
    ],
)
def test_what_is_no_chain(arcs: list[tuple[int, int]], tangents: tuple[int, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Chains.of(network(arcs, tangents))
