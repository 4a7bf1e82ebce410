"""Realizations: every source of errors does what it says, and none disturbs another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.dropping import Dropped
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.six_image_block import kind_design
from splinebba_cli.simulation.truth import at_truth
from tests.simulation.test_simulated_blocks import residuals

DESIGN = kind_design("six-image-mixed", 0.005)
QUIET = Noise(0.0)


def changed(network: Network) -> FloatArray:
    """Distance of every measured point of curves from its noise-free place, in σ."""
    exact, seen = DESIGN.network.curve_observations, network.curve_observations
    return np.asarray(np.linalg.norm(seen.photo_xy - exact.photo_xy, axis=1) / exact.sigma[:, 0])


def same(a: Network, b: Network) -> bool:
    """Whether two networks have the same measurements, given values and starts."""
    pairs = [
        (a.curve_observations.photo_xy, b.curve_observations.photo_xy),
        (a.point_observations.photo_xy, b.point_observations.photo_xy),
        (a.images.rotation, b.images.rotation),
        (a.images.position, b.images.position),
        (a.points.xyz, b.points.xyz),
        *((c.values, d.values) for c, d in zip(a.curves, b.curves, strict=True)),
    ]
    return all(np.array_equal(x, y, equal_nan=True) for x, y in pairs)


def test_the_same_seed_gives_the_same_network() -> None:
    noise = Noise(None, 3.0, 0.01, 1.0, 0.05, 20.0, 0.1, 0.1)
    first, again, other = (realize(DESIGN, noise, seed).network for seed in (5, 5, 6))
    assert same(first, again)
    assert not same(first, other)


def test_noise_has_the_declared_sigma_or_the_given_one() -> None:
    """Mean square of n standard normals: 1 with standard deviation sqrt(2 / n); four of them."""
    doubled = DESIGN.network.curve_observations.sigma * np.array([1.0, 2.0])
    seen = replace(DESIGN.network.curve_observations, sigma=doubled)
    design = Design(replace(DESIGN.network, curve_observations=seen), DESIGN.truth)
    exact = seen.photo_xy
    for noise, sigma in ((Noise(), doubled), (Noise(0.007), np.full_like(doubled, 0.007))):
        made = realize(design, noise, 3).network.curve_observations
        ratio = (made.photo_xy - exact) / sigma
        for column in ratio.T:
            assert abs(np.mean(column**2) - 1.0) < 4.0 * np.sqrt(2.0 / len(column))
        np.testing.assert_array_equal(made.sigma, doubled)  # what is declared stays


def test_blunders_have_their_number_and_size_and_leave_the_rest_alone() -> None:
    moved = changed(realize(DESIGN, replace(QUIET, blunder_share=0.05, blunder_size=30.0), 4).network)
    hit = moved > 1e-9
    assert hit.sum() == round(0.05 * len(moved))
    np.testing.assert_allclose(moved[hit], 30.0, rtol=1e-9)
    clean = realize(DESIGN, Noise(None), 4).network.curve_observations.photo_xy
    dirty = realize(DESIGN, Noise(None, blunder_share=0.05), 4).network.curve_observations.photo_xy
    assert (clean == dirty).all(axis=1).sum() == len(moved) - hit.sum()


def test_missing_points_are_dropped_with_their_true_locations() -> None:
    made = realize(DESIGN, replace(QUIET, missing_point_share=0.25), 4)
    whole = DESIGN.network
    for field in ("curve_observations", "point_observations"):
        count = len(getattr(whole, field))
        assert len(getattr(made.network, field)) <= count - round(0.25 * count)
    seen = made.network.curve_observations
    assert len(seen) == len(whole.curve_observations) - round(0.25 * len(whole.curve_observations))
    places = {
        tuple(xy): u for xy, u in zip(whole.curve_observations.photo_xy, DESIGN.truth.locations, strict=True)
    }
    assert [places[tuple(xy)] for xy in seen.photo_xy] == made.truth.locations.tolist()


def pairs_of(network: Network) -> set[tuple[str, str]]:
    seen = network.curve_observations
    rows = np.unique(np.column_stack([seen.image, seen.curve]), axis=0)
    return {(network.images.ids[i], network.curves[c].id) for i, c in rows}


def test_missing_pairs_are_dropped_as_a_whole() -> None:
    made = realize(DESIGN, replace(QUIET, missing_pair_share=0.2), 4)
    whole, left = pairs_of(DESIGN.network), pairs_of(made.network)
    out = {name.split("`")[1] for name in made.left_out}
    assert left < whole
    dropped = {pair for pair in whole - left if pair[1] not in out}
    assert len(dropped) <= round(0.2 * len(whole)) <= len(whole - left)
    seen, all_seen = made.network.curve_observations, DESIGN.network.curve_observations
    for image, curve in left:  # what is not dropped is complete
        k = [c.id for c in made.network.curves].index(curve)
        whole_k = [c.id for c in DESIGN.network.curves].index(curve)
        i = made.network.images.ids.index(image)
        count = ((seen.image == i) & (seen.curve == k)).sum()
        assert count == ((all_seen.image == i) & (all_seen.curve == whole_k)).sum()


def test_features_that_too_few_images_see_are_left_out() -> None:
    made = realize(DESIGN, replace(QUIET, missing_pair_share=0.5), 4)
    network, truth = made.network, made.truth
    assert made.left_out
    rays = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
    ties = np.array([role in ("tie", "check") for role in network.points.role])
    assert (rays[ties] >= 2).all() and (rays >= 1).all()
    np.testing.assert_array_equal(truth.points, DESIGN.truth.points[made.points])
    for place, curve, values in zip(made.curves, network.curves, truth.curves, strict=True):
        assert curve.id == DESIGN.network.curves[place].id
        np.testing.assert_array_equal(values, DESIGN.truth.curves[place])
    assert_measured_at_the_truth(made)


def assert_measured_at_the_truth(made: Dropped) -> None:
    """Indices were renumbered rightly: the noise-free measurements still fit the truth."""
    assert np.abs(residuals(at_truth(made.network, made.truth))).max() < 1e-11


def test_starts_are_those_of_the_project_unless_errors_are_asked_for() -> None:
    shifted = replace(DESIGN.network.images, position=DESIGN.truth.eop[:, 3:] + 7.0)
    design = Design(replace(DESIGN.network, images=shifted), DESIGN.truth)
    np.testing.assert_array_equal(realize(design, Noise(), 2).network.images.position, shifted.position)
    near = realize(design, Noise(start_position_m=0.5), 2).network
    error = np.abs(near.images.position - DESIGN.truth.eop[:, 3:])
    assert 0.25 < error.max() <= 0.5
    assert np.isnan(near.points.xyz[np.array(near.points.role) == "tie"]).all()
    np.testing.assert_array_equal(near.images.rotation, design.network.images.rotation)


def test_fixed_orientations_are_not_perturbed() -> None:
    sigma = np.full((6, 6), np.inf)
    sigma[0], sigma[1, 5] = 0.0, 0.0
    prior = np.where(np.isfinite(sigma), DESIGN.truth.eop, np.nan)
    images = replace(DESIGN.network.images, prior=prior, prior_sigma=sigma)
    made = realize(Design(replace(DESIGN.network, images=images), DESIGN.truth), Noise(None, 3.0, 0.02), 2)
    found = made.network.images
    np.testing.assert_array_equal(found.position[0], DESIGN.truth.eop[0, 3:])
    np.testing.assert_array_equal(found.rotation[0], DESIGN.truth.rotation[0])
    assert found.position[1, 2] == DESIGN.truth.eop[1, 5]
    assert (found.position[1, :2] != DESIGN.truth.eop[1, 3:5]).all()


@pytest.mark.parametrize("drawn", [True, False])
def test_given_values_have_errors_of_their_sigma_or_none(drawn: bool) -> None:
    made = realize(DESIGN, Noise(None, given_values=drawn), 2).network
    known = np.isfinite(made.points.sigma) | np.isfinite(made.points.check_sigma)
    error = (made.points.xyz - DESIGN.truth.points)[known]
    assert (error != 0.0).all() if drawn else (error == 0.0).all()
    if drawn:  # 36 values of 20 mm: the mean square is 1 ± 4 sqrt(2 / 36)
        assert abs(np.mean((error / 0.02) ** 2) - 1.0) < 4.0 * np.sqrt(2.0 / error.size)
    held = np.concatenate([c.sigma == 0.0 for c in made.curves])
    values = np.concatenate([c.values for c in made.curves])
    np.testing.assert_array_equal(values[held], np.concatenate(DESIGN.truth.curves)[held])
