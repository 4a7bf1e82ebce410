"""Pieces, directions and noise of chains."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.chain_block import PIXEL_MM, chain_network
from splinebba_cli.core.matching.fragments.traced_chains import DIRECTION_FLOOR_RAD, TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, UnlabelledPoints
from tests.core.matching.fragments.small_scenes import CORNERS, vertical_views

STEP = 10.0 * PIXEL_MM


def traced(xy: FloatArray, chain: list[int] | None = None, sigma_px: float = 0.5) -> TracedChains:
    count = len(xy)
    points = UnlabelledPoints(
        image=np.zeros(count, dtype=np.int64),
        photo_xy=xy,
        sigma=np.full((count, 2), sigma_px * PIXEL_MM),
        chain=np.zeros(count, dtype=np.int64) if chain is None else np.array(chain),
        direction=np.full(count, np.nan),
        chain_ids=("a", "b"),
    )
    rotation, position = vertical_views(CORNERS)
    network = chain_network(points, rotation, position)
    return TracedChains.of(network, Views.of(network, rotation, position), np.arange(count))


def line(count: int) -> FloatArray:
    return np.column_stack([STEP * np.arange(count), np.zeros(count)])


def test_a_chain_is_cut_where_it_jumps() -> None:
    xy = line(20)
    xy[12:, 0] += 4.0 * STEP
    assert list(np.diff(traced(xy).start)) == [12, 8]


def test_uneven_steps_are_no_jumps() -> None:
    xy = np.column_stack([np.cumsum(STEP * np.tile([1.0, 3.0], 10)), np.zeros(20)])
    assert list(np.diff(traced(xy).start)) == [20]


def test_a_chain_is_cut_where_it_turns_back() -> None:
    xy = np.vstack([line(10), line(10)[::-1] + [-0.5 * STEP, 0.3 * STEP]])
    assert list(np.diff(traced(xy).start)) == [10, 10]


def test_noise_of_points_that_nearly_coincide_is_no_turn() -> None:
    xy = line(20)
    xy[10] = xy[9] - [0.1 * PIXEL_MM, 0.0]
    assert list(np.diff(traced(xy).start)) == [20]


def test_single_points_are_left_out() -> None:
    assert len(traced(line(6), chain=[0, 0, 0, -1, -1, 1])) == 4


def test_a_corner_of_a_right_angle_keeps_both_directions() -> None:
    one = line(10)
    two = one[-1] + np.column_stack([np.zeros(10), STEP * np.arange(1, 11)])
    tangent = traced(np.vstack([one, two])).tangent
    assert np.abs(tangent[:8, 0]) == pytest.approx(1.0, abs=1e-9)
    assert np.abs(tangent[12:, 1]) == pytest.approx(1.0, abs=1e-9)
    mixed = np.min(np.abs(tangent), axis=1) > 0.2
    assert mixed.sum() <= 1


def test_directions_scatter_as_their_sigma_says() -> None:
    """The noise of 3000 slopes: its variance is within 10 % of the predicted one (4 sigma of independent ones)."""
    generator = np.random.default_rng(1)
    xy = line(3000) + generator.normal(0.0, 0.5 * PIXEL_MM, (3000, 2))
    chains = traced(xy)
    inner = slice(10, -10)
    angle = np.arctan2(chains.tangent[inner, 1], chains.tangent[inner, 0])
    predicted = chains.tangent_sigma[inner] ** 2 - DIRECTION_FLOOR_RAD**2
    assert np.mean(angle**2) == pytest.approx(np.mean(predicted), rel=0.15)


def test_sigma_is_that_across_the_chain() -> None:
    xy = line(12)
    points = traced(xy, sigma_px=0.7)
    assert points.sigma == pytest.approx(0.7 * PIXEL_MM, rel=1e-9)
