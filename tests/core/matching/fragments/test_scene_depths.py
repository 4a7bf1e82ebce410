"""Plausible depths: from object points, from frames, narrowed where chains crowd; partners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import chain_block
from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.narrowed_depths import crowded_depths, narrowed
from splinebba_cli.core.matching.fragments.partners import partner_images
from splinebba_cli.core.matching.fragments.scene_depths import SceneDepths, plausible_depths
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import Curve, Network, PointObservations, Points

TRUE_M = (970.0, 1000.0)  # of the blocks: heights from 0 to 30 m, flown at 1000 m
MM = 100.0  # principal distance


def prepared(network: Network) -> tuple[Views, TracedChains, Frames, SceneDepths]:
    views = Views.of(network, network.images.rotation, network.images.position)
    chains = TracedChains.of(network, views, np.arange(len(network.unlabelled)))
    frames = Frames.of(views, chains)
    return views, chains, frames, plausible_depths(network, network.points.xyz, views, chains, frames)


def with_points(network: Network, heights: np.ndarray) -> Network:
    """Points at these heights, seen by image 0."""
    count = len(heights)
    xyz = np.column_stack([np.linspace(-50.0, 50.0, count), np.zeros(count), heights])
    none = np.full((count, 3), np.nan)
    names = tuple(map(str, range(count)))
    points = Points(names, ("tie",) * count, xyz, np.full((count, 3), np.inf), none)
    image, two = np.zeros(count, dtype=np.int64), np.ones((count, 2))
    return replace(
        network, points=points, point_observations=PointObservations(image, np.arange(count), two, two)
    )


def test_measured_points_tell_the_depths_and_leave_a_margin() -> None:
    network = with_points(chain_block(3, 1, 10).network, np.linspace(0.0, 20.0, 8))
    scene = prepared(network)[3]
    assert list(scene.known) == [True, False, False]
    low, high = scene.limits[0] * MM
    # 3 % of the depth, more than the range, beyond 980 and 1000 m (flown 5 m higher or lower)
    assert 930.0 < low < 965.0
    assert 1015.0 < high < 1050.0


@pytest.mark.parametrize("family", ["circle", "polynomial_2", "natural_cubic"])
def test_curves_tell_the_depths_by_their_places(family: str) -> None:
    """Values that are no places of the curve, radii and coefficients, are of height 0 here, 30 m below it."""
    values = {
        "circle": [[0.0, 0.0, 30.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0]],
        "polynomial_2": [[0.0, 0.0, 30.0], [20.0, 10.0, 0.0], [1.0, 3.0, 0.0]],
        "natural_cubic": np.column_stack([np.linspace(-40.0, 40.0, 6), np.zeros(6), np.full(6, 30.0)]),
    }[family]
    rows = np.array(values)
    block = chain_block(3, 1, 10).network
    curves = tuple(Curve(str(k), "control", family, rows, np.zeros(rows.shape)) for k in range(4))  # type: ignore[arg-type]
    scene = prepared(replace(block, curves=curves))[3]
    assert scene.known[0]
    low, high = scene.limits[0] * MM
    distance = block.images.position[0, 2] - 30.0
    assert low == pytest.approx(0.97 * distance, abs=4.0)
    assert high == pytest.approx(1.03 * distance, abs=4.0)


def test_few_points_tell_nothing() -> None:
    network = with_points(chain_block(3, 1, 10).network, np.linspace(0.0, 20.0, 7))
    assert not prepared(network)[3].known.any()


def test_without_points_the_true_depths_are_within_what_frames_allow() -> None:
    *_, scene = prepared(chain_block(3, 2, 30).network)
    assert (scene.limits[:, 0] * MM < TRUE_M[0]).all()
    assert (scene.limits[:, 1] * MM > TRUE_M[1]).all()


def test_depths_are_narrowed_where_chains_crowd() -> None:
    views, chains, frames, scene = prepared(chain_block(3, 2, 400).network)
    close = narrowed(views, chains, frames, scene, 3.3)
    low, high = (close.limits * MM).T
    assert np.median(high - low) < 250.0
    assert (low < TRUE_M[0]).all()
    assert (high > TRUE_M[1]).all()
    assert close.middle * MM == pytest.approx(985.0, abs=40.0)


def test_depths_are_found_in_a_long_strip() -> None:
    """Bases of three kilometres leave depths of a hundred kilometres open; neighbours see the same at one of them."""
    views, chains, frames, scene = prepared(chain_block(10, 1, 60).network)
    assert (scene.limits[:, 1] > 50.0 * scene.limits[:, 0]).all()
    close = narrowed(views, chains, frames, scene, 3.3)
    assert close.middle[1:-1] * MM == pytest.approx(985.0, abs=40.0)
    partners = partner_images(views, chains, frames, close)
    assert all({k - 1, k + 1} <= set(partners[k]) for k in range(1, 9))


def test_agreement_by_chance_is_told_from_a_crowd() -> None:
    """Chance spreads evenly over inverse depth; the crowd is between 9.7 and 10 m."""
    generator = np.random.default_rng(1)
    chance = 1.0 / generator.uniform(1.0 / 100.0, 1.0 / 4.0, 10 * 256)
    crowd = generator.uniform(9.7, 10.0, 300)
    low, most, high = crowded_depths(np.concatenate([chance, crowd]), np.array([4.0, 100.0]))
    assert 9.3 < low < 9.7
    assert 9.7 < most < 10.0
    assert 10.0 < high < 10.5
    assert np.isnan(crowded_depths(chance, np.array([4.0, 100.0]))).all()


def test_depths_stay_open_where_chains_are_few() -> None:
    views, chains, frames, scene = prepared(chain_block(3, 2, 20).network)
    close = narrowed(views, chains, frames, scene, 3.3)
    assert np.array_equal(close.limits, scene.limits)


def test_partners_see_the_same() -> None:
    """Seven images in a row with 60 % overlap: nobody meets the third neighbour, at -20 %."""
    network = chain_block(7, 1, 20).network
    views, chains, frames, scene = prepared(network)
    limits = np.tile([9.0, 11.0], (7, 1))
    scene = SceneDepths(limits, np.full(7, 9.85), scene.known)
    partners = partner_images(views, chains, frames, scene)
    assert set(partners[3]) == {1, 2, 4, 5}
    assert set(partners[0]) == {1, 2}


def test_frames_hold_the_chains_and_little_more() -> None:
    views, chains, frames, _ = prepared(chain_block(2, 1, 10).network)
    xyz = views.position[chains.image] + 9.9 * chains.ray
    assert frames.shows(views, chains.image, xyz).all()
    own = chains.xy[chains.image == 0]
    assert (frames.low[0] > own.min(axis=0) - 5.0).all()
    assert (frames.high[0] < own.max(axis=0) + 5.0).all()
