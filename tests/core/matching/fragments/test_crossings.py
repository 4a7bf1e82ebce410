"""Crossings of epipolar lines with chains, against every point with every step."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.matching.fragments.crossings import epipolar_crossings
from splinebba_cli.core.matching.fragments.hypotheses import depth_hypotheses
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray
from tests.core.matching.fragments.small_scenes import CORNERS, IN_LINE, arc, scene, straight

DEPTHS = np.array([9.0, 11.0])


def prepared(
    curves: FloatArray, ground: FloatArray = CORNERS, sigma_px: float = 0.0
) -> tuple[Views, TracedChains]:
    network = scene(curves, ground, sigma_px).network
    views = Views.of(network, network.images.rotation, network.images.position)
    return views, TracedChains.of(network, views, np.arange(len(network.unlabelled)))


def tangle() -> list[FloatArray]:
    generator = np.random.default_rng(2)
    starts = generator.uniform([-80.0, -60.0, 0.0], [60.0, 60.0, 30.0], (12, 3))
    ways = generator.normal(0.0, 1.0, (12, 3)) * [1.0, 1.0, 0.1]
    return [straight(tuple(a), tuple(b), 50) for a, b in zip(starts, ways, strict=True)]


@pytest.mark.parametrize("ground", [CORNERS, IN_LINE], ids=["corners", "in line"])
def test_all_crossings_are_found_once(ground: FloatArray) -> None:
    views, chains = prepared(tangle(), ground)
    points, segments = np.flatnonzero(chains.image == 0), chains.segment[chains.image[chains.segment] == 1]
    found = epipolar_crossings(views, chains, points, segments, DEPTHS)
    base = views.position[1] - views.position[0]
    plane = np.cross(base, chains.ray[points])
    side = np.sign(plane @ chains.ray[chains.image == 1].T)
    number = segments - np.flatnonzero(chains.image == 1)[0]
    row, column = np.nonzero(side[:, number] != side[:, number + 1])
    a, b = chains.ray[segments[column]], chains.ray[segments[column] + 1]
    one, two = np.sum(plane[row] * a, axis=1), np.sum(plane[row] * b, axis=1)
    there = a + (one / (one - two))[:, None] * (b - a)
    expected = set()
    for p, s, ray in zip(points[row], segments[column], there, strict=True):
        (depth, other), *_ = np.linalg.lstsq(np.column_stack([chains.ray[p], -ray]), base, rcond=None)
        if DEPTHS[0] <= depth <= DEPTHS[1] and other > 0.0:
            expected.add((int(p), int(s)))
    pairs = list(zip(found.point.tolist(), found.first.tolist(), strict=True))
    assert len(expected) > 800
    assert len(pairs) == len(set(pairs))
    assert set(pairs) == expected


def test_crossing_of_the_same_edge_is_where_the_edge_is() -> None:
    views, chains = prepared([straight((-100.0, -60.0, 5.0), (2.0, 1.0, 0.1))])
    points, segments = np.flatnonzero(chains.image == 0), chains.segment[chains.image[chains.segment] == 3]
    found = epipolar_crossings(views, chains, points, segments, DEPTHS)
    xyz = views.position[0] + found.depth[:, None] * chains.ray[found.point]
    offset = xyz - [-100.0, -60.0, 5.0]
    along = np.array([2.0, 1.0, 0.1]) / np.linalg.norm([2.0, 1.0, 0.1])
    assert len(xyz) > 30
    assert np.linalg.norm(offset - (offset @ along)[:, None] * along, axis=1).max() < 1e-9


def test_the_end_of_a_piece_is_a_place_of_its_last_step() -> None:
    """A plane exactly through the end: the step of its place must not lead on to the next piece."""
    ray = np.array([[0.0, 0.0, -1.0], [0.0, -0.1, -1.0], [-0.5, 0.0, -1.0], [0.3, 0.4, -1.0]])
    zero = np.zeros(4)
    chains = TracedChains(
        row=np.arange(4), image=np.array([0, 1, 1, 1]), piece=np.array([0, 1, 1, 2]), start=np.array([0, 1, 3, 4]),
        xy=ray[:, :2], arc=zero, tangent=np.tile([1.0, 0.0], (4, 1)), tangent_sigma=zero, sigma=zero, ray=ray,
    )  # fmt: skip
    views = Views(np.tile(np.eye(3), (2, 1, 1)), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.ones(2))
    found = epipolar_crossings(views, chains, np.array([0]), np.array([1]), np.array([1.0, 5.0]))
    assert found.depth == pytest.approx([2.0])
    assert (found.first + found.fraction).astype(int).tolist() == [1]


def test_slope_of_depth_is_that_of_the_edge() -> None:
    views, chains = prepared([straight((-100.0, -60.0, 5.0), (2.0, 1.0, 0.3))])
    points, segments = np.flatnonzero(chains.image == 0), chains.segment[chains.image[chains.segment] == 3]
    found = depth_hypotheses(views, chains, epipolar_crossings(views, chains, points, segments, DEPTHS))
    slope = np.gradient(found.depth, chains.arc[found.point])
    assert len(found) > 30
    assert found.slope[2:-2] == pytest.approx(slope[2:-2], rel=1e-3)


def test_depth_scatters_as_its_sigma_says() -> None:
    """Mean square of 2 x 40 x 30 errors over their sigma, neighbours dependent through the steps that they share."""
    curve = straight((-100.0, -60.0, 5.0), (2.0, 1.0, 0.3))
    along = (curve[1] - curve[0]) / np.linalg.norm(curve[1] - curve[0])
    squares = []
    for seed in range(30):
        network = scene([curve], sigma_px=0.5, seed=seed).network
        views = Views.of(network, network.images.rotation, network.images.position)
        chains = TracedChains.of(network, views, np.arange(len(network.unlabelled)))
        points, segments = (
            np.flatnonzero(chains.image == 0),
            chains.segment[chains.image[chains.segment] == 3],
        )
        found = depth_hypotheses(views, chains, epipolar_crossings(views, chains, points, segments, DEPTHS))
        ray = chains.ray[found.point]
        start = views.position[0] - curve[0]
        normal = np.cross(along, np.cross(ray, along))
        depth = -np.sum(start * normal, axis=1) / np.sum(ray * normal, axis=1)
        squares.append(((found.depth - depth) / found.sigma) ** 2)
    # where a step is crossed at its middle, the mean of two points is half as noisy: between 2/3 and 1
    assert 0.55 < np.concatenate(squares).mean() < 1.1


@pytest.mark.parametrize("sigma_px", [0.0, 0.5])
def test_no_depth_of_a_chain_along_the_epipolar_line(sigma_px: float) -> None:
    views, chains = prepared([straight((-70.0, 0.0, 0.0), (1.0, 0.0, 0.0))], IN_LINE, sigma_px)
    points, segments = np.flatnonzero(chains.image == 0), chains.segment[chains.image[chains.segment] == 3]
    found = depth_hypotheses(views, chains, epipolar_crossings(views, chains, points, segments, DEPTHS))
    assert len(found) == 0


def test_no_depth_of_an_edge_along_a_line_of_sight() -> None:
    """Nearly all points of an edge along the base see nearly one place of an edge that crosses there."""
    along, aside = (
        straight((-20.0, 0.0, 0.0), (1.0, 0.1, 0.0), 30),
        straight((0.0, -20.0, 0.0), (0.0, 1.0, 0.0), 30),
    )
    views, chains = prepared([along, aside], IN_LINE)
    points = np.flatnonzero(chains.piece == chains.piece[chains.image == 0][0])
    segments = chains.segment[chains.piece[chains.segment] == chains.piece[chains.image == 3][-1]]
    found = depth_hypotheses(views, chains, epipolar_crossings(views, chains, points, segments, DEPTHS))
    crossed = epipolar_crossings(views, chains, points, segments, DEPTHS)
    places = crossed.first + crossed.fraction
    assert len(places) > 20
    assert np.ptp(places) < 4.0
    assert len(found) == 0


def test_directions_predict_the_third_image() -> None:
    """Slopes from two images agree, for a straight edge and for a bent one."""
    true = straight((-100.0, 0.0, 5.0), (1.0, 0.3, 0.0))
    views, chains = prepared([true])
    arcs_views, arcs = prepared([arc(80.0, 1.2)])
    for v, c in ((views, chains), (arcs_views, arcs)):
        points = np.flatnonzero(c.image == 0)
        slope = {}
        for k in (1, 3):
            segments = c.segment[c.image[c.segment] == k]
            found = depth_hypotheses(v, c, epipolar_crossings(v, c, points, segments, DEPTHS))
            slope[k] = dict(zip(found.point, zip(found.slope, found.slope_sigma, strict=True), strict=True))
        both = sorted(set(slope[1]) & set(slope[3]))
        z = [(slope[1][p][0] - slope[3][p][0]) / np.hypot(slope[1][p][1], slope[3][p][1]) for p in both[3:-3]]
        assert len(z) > 15
        assert np.abs(z).max() < 1.5
