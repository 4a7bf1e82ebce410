"""The most influential observations leave out those in which no error is ever found."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import Images, Network, PointObservations, Points, select_rows
from splinebba_cli.simulation.six_image_block import simulate_block


def _one_point_in_two_fixed_images() -> Network:
    """Normal case, one tie point: redundancy 1, all of it in y; x is checked by nothing."""
    given = simulate_block("six-image", 1)[0]
    position = np.array([[0.0, 0.0, 1000.0], [600.0, 0.0, 1000.0]])
    rotation = rotation_object_from_photo(np.zeros((2, 3)))
    camera = replace(given.cameras[0], principal_distance_mm=100.0)
    xyz = np.array([[300.0, 50.0, 0.0]])
    xy = 0.1 * (xyz[0, :2] - position[:, :2]) + np.array([[0.0, 0.004], [0.0, -0.002]])
    images = Images(
        ids=("1", "2"),
        camera=np.zeros(2, dtype=np.int64),
        rotation=rotation,
        position=position,
        sequence=("omega-phi-kappa",) * 2,
        prior=np.column_stack([angles_from_rotation(rotation), position]),
        prior_sigma=np.zeros((2, 6)),
    )
    seen = PointObservations(np.array([0, 1]), np.zeros(2, dtype=np.int64), xy, np.full((2, 2), 0.005))
    points = Points(("p",), ("tie",), xyz, np.full((1, 3), np.inf), np.full((1, 3), np.nan))
    nothing = select_rows(given.curve_observations, np.zeros(0, dtype=np.int64))
    return Network(np.zeros(3), (camera,), images, points, (), seen, nothing)


def test_what_nothing_checks_is_no_candidate() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = adjust(_one_point_in_two_fixed_images())
    assert found.point_residuals.redundancy == pytest.approx(np.array([[0.0, 0.5], [0.0, 0.5]]), abs=1e-12)
    assert {influence.name[-1] for influence in found.evidence.influences} == {"y"}


def test_with_fixed_images_the_least_controlled_come_first() -> None:
    network = simulate_block("six-image-mixed", 1)[0]
    images = network.images
    prior = np.column_stack([angles_from_rotation(images.rotation), images.position])
    fixed = replace(images, prior=prior, prior_sigma=np.zeros_like(prior))
    found = adjust(replace(network, images=fixed))
    assert all(influence.orientation == 0.0 for influence in found.evidence.influences)
    of_points = [one.bias_to_noise for one in found.evidence.influences if one.kind == "point"]
    every = found.point_residuals.reliability.bias_to_noise
    redundancy = found.point_residuals.redundancy
    assert max(of_points) == pytest.approx(every[redundancy > 1e-9].max())
