"""Labels made observations, and what a scene says of points: noise, directions, other states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import CurveObservations, Network
from splinebba_cli.core.state import State, initial_coefficients, prepare
from tests.core.matching.fragments.small_scenes import scene, straight
from tests.core.matching.scenes import curve

LINE = straight((-120.0, 70.0, 0.0), (1.0, -0.4, 0.05))


def network() -> Network:
    given = scene([LINE]).network
    return replace(given, curves=(curve("straight_line", LINE[[0, -1]]),) * 2)


def state_of(given: Network) -> State:
    images = given.images
    coefficients = initial_coefficients(prepare(given))
    return State(
        images.rotation, images.position, coefficients, given.points.xyz, given.curve_observations.location
    )


def test_labelled_points_stand_behind_the_observations_that_there_were() -> None:
    given = network()
    count = len(given.unlabelled)
    points = replace(
        given.unlabelled, group=np.arange(count) % 2, group_names=("a", "b"), excluded=np.arange(count) == 5
    )
    one, two = np.zeros(1, dtype=np.int64), np.ones((1, 2))
    old = CurveObservations(one, one, two, two, np.zeros(1), one, one, ("old",))
    curves, location = np.full(count, -1), np.full(count, np.nan)
    curves[3:6], location[3:6] = [1, 0, 1], [0.1, 0.2, 0.3]
    factor = np.full(count, 2.0)
    made = with_labels(replace(given, unlabelled=points, curve_observations=old), curves, location, factor)
    observed, rest = made.curve_observations, made.unlabelled
    assert observed.curve.tolist() == [0, 1, 0, 1]
    assert observed.location.tolist() == [0.0, 0.1, 0.2, 0.3]
    assert observed.segment.tolist() == [0, -1, -1, -1]
    assert observed.group_names == ("old", "a", "b")
    assert observed.group is not None and observed.group.tolist() == [0, 2, 1, 2]
    assert observed.excluded is not None and observed.excluded.tolist() == [False, False, False, True]
    np.testing.assert_array_equal(observed.photo_xy[1:], points.photo_xy[3:6])
    np.testing.assert_allclose(observed.sigma[1:], 2.0 * points.sigma[3:6])
    np.testing.assert_array_equal(rest.photo_xy, np.delete(points.photo_xy, [3, 4, 5], axis=0))
    assert rest.excluded is not None and not rest.excluded.any()
    again = with_labels(given, curves, location)
    assert (
        again.curve_observations.group_names == ("", "matched") and again.curve_observations.excluded is None
    )


def test_noise_is_the_largest_of_a_point() -> None:
    given = network()
    sigma = np.tile([0.002, 0.006], (len(given.unlabelled), 1))
    given = replace(given, unlabelled=replace(given.unlabelled, sigma=sigma))
    assert Scene.of(given, state_of(given)).noise == pytest.approx(0.006)


def test_directions_are_corrected_as_points_are() -> None:
    """Two points in the direction of an edge, measured in a distorted photo, give it in the corrected one."""
    given = network()
    camera = replace(given.cameras[0], radial=np.array([3e-5, 0.0, 0.0]), affinity=np.array([0.1, 0.02]))
    points = given.unlabelled
    count = len(points) // 2
    angle = np.linspace(0.0, np.pi, count)
    step = 1e-4 * np.column_stack([np.cos(angle), np.sin(angle)])
    xy = np.concatenate([points.photo_xy[:count] - step, points.photo_xy[:count] + step])
    two = replace(
        points, image=np.tile(points.image[:count], 2), photo_xy=xy, sigma=points.sigma[: 2 * count],
        chain=points.chain[: 2 * count], direction=np.tile(angle, 2),
    )  # fmt: skip
    given = replace(given, cameras=(camera,), unlabelled=two)
    own = Scene.of(given, state_of(given))
    way = own.xy[count:] - own.xy[:count]
    turned = own.direction[:count] - np.arctan2(way[:, 1], way[:, 0])
    assert np.abs(np.sin(turned)).max() < 1e-4
    assert np.abs(np.sin(own.direction[:count] - angle)).max() > 0.02


def test_a_scene_follows_the_state() -> None:
    given = network()
    state = state_of(given)
    own = Scene.of(given, state)
    moved = replace(
        state, coefficients=state.coefficients + 1.0, position=state.position + 2.0,
        rotation=np.swapaxes(state.rotation, 1, 2),
    )  # fmt: skip
    other = own.at(moved)
    np.testing.assert_array_equal(other.position, moved.position)
    np.testing.assert_array_equal(other.rotation, moved.rotation)
    np.testing.assert_allclose(other.polynomials[:, 0], own.polynomials[:, 0] + 1.0)
    np.testing.assert_array_equal(other.xy, own.xy)
