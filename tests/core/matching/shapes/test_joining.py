"""Strands joined across gaps, and what is not joined."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.shapes.joining import joined_strands, joints_of
from splinebba_cli.core.matching.shapes.strand import Strand, strand_of
from splinebba_cli.core.network import FloatArray, IntArray
from tests.core.matching.fragments.small_scenes import arc, straight
from tests.core.matching.shapes.edges import fragment

LINE = straight((0.0, 0.0, 10.0), (1.0, 0.3, 0.0), 80)


def strand(xyz: FloatArray, rows: IntArray | None = None, seed: int = 1) -> Strand:
    noise = np.random.default_rng(seed).normal(0.0, 0.03, xyz.shape)
    places = None if rows is None else np.arange(len(rows), dtype=float)
    found = strand_of(fragment(xyz + noise, 0.03, rows, places))
    assert found is not None
    return found


def alone(count: int) -> tuple[IntArray, IntArray]:
    """Chains and images of points none of which belong together."""
    return np.full(count, -1), np.zeros(count, dtype=np.int64)


def test_a_short_gap_of_a_straight_edge_is_joined() -> None:
    parts = [strand(LINE[:35]), strand(LINE[41:], seed=2)]
    (whole,) = joined_strands(parts, *alone(0))
    assert whole.length > 110.0


def test_a_long_gap_is_joined_only_where_a_chain_crosses_it() -> None:
    first, second = LINE[:20], LINE[45:65]
    assert len(joined_strands([strand(first), strand(second, seed=2)], *alone(0))) == 2
    rows = np.arange(20)
    chain, image = np.zeros(45, dtype=np.int64), np.zeros(45, dtype=np.int64)
    parts = [strand(first, rows), strand(second, 25 + rows, seed=2)]  # points 20 .. 24 cross the gap
    (whole,) = joined_strands(parts, chain, image)
    assert len(whole.link_row) == 40


def test_the_sense_of_a_part_does_not_matter() -> None:
    parts = [strand(LINE[:35]), strand(LINE[41:][::-1], seed=2)]
    (whole,) = joined_strands(parts, *alone(0))
    step = np.diff(whole.line @ np.array([1.0, 0.3, 0.0]))
    assert (step > 0.0).all() or (step < 0.0).all()


def test_parallel_and_shifted_ends_are_not_joined() -> None:
    shifted = LINE[38:] + np.array([0.0, 1.5, 0.0])
    assert len(joined_strands([strand(LINE[:35]), strand(shifted, seed=2)], *alone(0))) == 2


def test_a_chain_around_a_corner_does_not_join() -> None:
    corner = LINE[30] + 1.5 * np.arange(1, 31)[:, None] * np.array([-0.3, 1.0, 0.0]) / np.hypot(1.0, 0.3)
    rows = np.arange(30)
    parts = [strand(LINE[:30], rows), strand(corner, 30 + rows, seed=2)]
    assert len(joined_strands(parts, np.zeros(60, dtype=np.int64), np.zeros(60, dtype=np.int64))) == 2


def test_one_chain_does_not_outweigh_two_images_whose_chains_end() -> None:
    rows = np.arange(10)
    chain = np.r_[np.zeros(20), np.full(10, 1), np.full(10, 2), np.full(10, 3), np.full(10, 4)].astype(
        np.int64
    )
    image = np.r_[np.zeros(20), np.full(20, 1), np.full(20, 2)].astype(np.int64)
    aside = LINE[38:68] + np.array([0.0, 1.2, 0.0])
    first = strand(LINE[:30], np.r_[rows, 20 + rows, 40 + rows])
    second = strand(aside, np.r_[10 + rows, 30 + rows, 50 + rows], seed=2)

    def at_ends(each: Strand, first_end: bool) -> Strand:
        place = np.tile(np.linspace(0.8, 1.0, 10) if first_end else np.linspace(0.0, 0.2, 10), 3)
        return Strand(**{**vars(each), "link_location": place * each.length})

    parts = [at_ends(first, True), at_ends(second, False)]
    assert joints_of(parts, chain, image) == []
    alike = [at_ends(first, True), at_ends(second, False)]
    assert len(joints_of(alike, np.repeat([0, 1, 2], 20), image)) == 1


def test_an_end_is_joined_once_and_not_where_two_fit_alike() -> None:
    """Behind the end two edges begin side by side, 0.1 m apart, both straight on."""
    first, second = strand(LINE[:35]), strand(LINE[41:], seed=2)
    beside = strand(LINE[41:] + np.array([0.0, 0.0, 0.1]), seed=3)
    assert len(joined_strands([first, second, beside], *alone(0))) == 3
    assert len(joined_strands([first, second], *alone(0))) == 1
    assert len(joined_strands([first, beside], *alone(0))) == 1


def test_a_nearly_closed_edge_becomes_a_ring() -> None:
    ring = arc(30.0, 2.0 * np.pi - 0.15)
    (whole,) = joined_strands([strand(ring)], *alone(0))
    assert whole.closed
    full = arc(30.0, 2.0 * np.pi)
    assert abs(whole.length - np.linalg.norm(np.diff(full, axis=0), axis=1).sum()) < 3.0
