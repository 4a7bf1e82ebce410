"""The list of measurements, what cannot stay without another, and networks with factors of weights."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Network, select_rows
from splinebba_cli.core.revision.data_snooping import companions
from splinebba_cli.core.revision.observation_list import CURVES, ObservationList
from splinebba_cli.core.revision.observation_weights import FAINT, faintly_weighted, lost_points, reduced
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.six_image_block import simulate_block


@cache
def linked_network() -> Network:
    network, truth = simulate_block("six-image-mixed", 2)
    network = with_arc_lengths(network, truth, 0.005, np.random.default_rng(1))
    return with_tangents(network, truth, 1e-3, np.random.default_rng(2))


def test_names_and_places() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    points = len(network.point_observations)
    kinds = (network.point_observations, network.curve_observations, network.arc_lengths, network.tangents)
    assert len(listed) == sum(map(len, kinds))
    seen = network.curve_observations
    expected = f"image `{network.images.ids[seen.image[7]]}`, spline `{network.curves[seen.curve[7]].id}`"
    assert listed.name(points + 7) == expected
    assert listed.name(int(listed.starts[CURVES + 1])).endswith(", arc length")


def test_arcs_and_tangents_go_with_their_point() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    arc = int(np.flatnonzero(np.isin(network.arc_lengths.second, network.arc_lengths.first))[0])
    middle = int(network.arc_lengths.second[arc])
    followers, reasons = companions(
        listed, np.ones(len(listed), dtype=bool), np.array([listed.starts[CURVES] + middle])
    )
    arcs = (network.arc_lengths.first == middle) | (network.arc_lengths.second == middle)
    assert len(followers) == arcs.sum() + (network.tangents.point == middle).sum()
    assert arcs.sum() == 2
    assert set(reasons) == {"its measured point is rejected"}


def test_the_last_ray_of_a_tie_point_goes_too_and_that_of_a_control_point_stays() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    used = np.ones(len(listed), dtype=bool)
    seen = network.point_observations.point
    roles = np.array(network.points.role)
    for role, left in (("tie", 0), ("control", 1)):
        point = int(np.flatnonzero((roles == role) & (np.bincount(seen) >= 2))[0])
        rays = np.flatnonzero(seen == point)
        followers, _ = companions(listed, used, rays[1:])
        assert len(rays) - len(rays[1:]) - len(followers) == left


def test_reduced_network_keeps_what_its_arcs_and_tangents_mean() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    factor = np.ones(len(listed))
    gone = listed.starts[CURVES] + np.arange(0, len(network.curve_observations), 50)
    factor[gone] = 0.0
    followers, _ = companions(listed, factor > 0.0, gone)
    factor[followers] = 0.0
    part = reduced(listed, factor)
    before, after = network.curve_observations.photo_xy, part.network.curve_observations.photo_xy
    arcs, kept = network.arc_lengths, part.network.arc_lengths
    np.testing.assert_array_equal(after[kept.first], before[arcs.first[part.arcs]])
    np.testing.assert_array_equal(after[kept.second], before[arcs.second[part.arcs]])
    np.testing.assert_array_equal(
        after[part.network.tangents.point], before[network.tangents.point[part.tangents]]
    )
    assert not np.isin(gone - listed.starts[CURVES], part.curves).any()


def test_a_factor_divides_the_variance() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    factor = np.full(len(listed), 0.25)
    factor[0] = 0.0
    faint = faintly_weighted(prepare(network), listed, factor)
    np.testing.assert_allclose(faint.network.curve_observations.sigma, 2.0 * network.curve_observations.sigma)
    np.testing.assert_allclose(
        faint.network.point_observations.sigma[0], network.point_observations.sigma[0] / np.sqrt(FAINT)
    )
    again = prepare(faint.network)  # the same by the way from the network
    np.testing.assert_allclose(faint.curve_rays.whitening, again.curve_rays.whitening)
    np.testing.assert_allclose(faint.arc_lengths.sigma, again.arc_lengths.sigma)
    np.testing.assert_allclose(faint.tangents.sigma, again.tangents.sigma)
    part = reduced(listed, factor)
    np.testing.assert_allclose(part.network.tangents.sigma, 2.0 * network.tangents.sigma)


def test_a_point_without_rays_is_held() -> None:
    network = linked_network()
    listed = ObservationList.of(network)
    point = int(np.flatnonzero(np.array(network.points.role) == "tie")[0])
    factor = np.ones(len(listed))
    factor[np.flatnonzero(network.point_observations.point == point)] = 0.0
    assert lost_points(listed, factor).tolist() == [point]
    place = np.full((len(network.points.ids), 3), 7.0)
    part = reduced(listed, factor, place)
    assert (part.network.points.sigma[point] == 0.0).all()
    assert (part.network.points.xyz[point] == 7.0).all()


@pytest.mark.parametrize("kinds", ["points", "curves and what hangs on them"])
def test_excluded_by_the_user_is_the_same_as_never_measured(kinds: str) -> None:
    """Rounding of another order of sums, against σ: 1e-6 is the step at which iterations end."""
    network = linked_network() if kinds != "points" else simulate_block("six-image-mixed", 2)[0]
    rng = np.random.default_rng(3)
    if kinds == "points":
        seen = network.point_observations.point
        many = np.flatnonzero((np.bincount(seen) >= 4)[seen])  # which three rays leave located
        rows = many[[0, len(many) // 2, -1]]
        flags = np.zeros(len(network.point_observations), dtype=bool)
        flags[rows] = True
        marked = replace(network, point_observations=replace(network.point_observations, excluded=flags))
        kept = replace(
            network, point_observations=select_rows(network.point_observations, np.flatnonzero(~flags))
        )
    else:
        flags = np.zeros(len(network.curve_observations), dtype=bool)
        flags[rng.choice(len(flags), 20, replace=False)] = True
        marked = replace(network, curve_observations=replace(network.curve_observations, excluded=flags))
        listed = ObservationList.of(marked)
        kept = reduced(listed, np.where(listed.excluded(), 0.0, 1.0)).network
    found, expected = adjust(marked), adjust(kept)
    assert found.statistics.observations == expected.statistics.observations
    assert found.statistics.redundancy == expected.statistics.redundancy
    sigma = np.sqrt(np.einsum("mii->mi", expected.images.dispersion))
    assert (np.abs(found.images.eop - expected.images.eop) < 1e-5 * sigma).all()
    assert found.statistics.sigma0 == pytest.approx(expected.statistics.sigma0, rel=1e-7)
    assert len(found.curve_residuals.across) == len(network.curve_observations)
    assert [p.code for p in found.problems].count("SBB544") == 1
