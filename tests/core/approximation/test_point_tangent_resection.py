"""Resection from points of which some have tangents: few of them, many wrong ones, and inside of a network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.approximation.located_sights import LocatedSights
from splinebba_cli.core.approximation.orientation import approximate_orientations
from splinebba_cli.core.approximation.point_tangent_resection import PointsWithTangents, resect_with_tangents
from splinebba_cli.core.approximation.resection import ResectionError
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, Network, Tangents, select_rows
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.six_image_block import simulate_block

C = 150.0
ROTATION = rotation_object_from_photo(np.array([0.1, -0.05, 0.7]))
POSITION = np.array([20.0, -30.0, 480.0])


def seen(count: int, seed: int, with_tangent: int, directed: bool = False) -> PointsWithTangents:
    """Exact measurements of random points; the first ones have tangents."""
    rng = np.random.default_rng(seed)
    xyz = rng.uniform([-220.0, -220.0, -40.0], [220.0, 220.0, 40.0], (count, 3))
    tangent = rng.normal(size=(count, 3))
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    p, t = (xyz - POSITION) @ ROTATION, tangent @ ROTATION
    xy = -C * p[:, :2] / p[:, 2:]
    flow = t[:, :2] + xy * t[:, 2:] / C
    direction = flow / np.linalg.norm(flow, axis=1, keepdims=True)
    direction[with_tangent:], tangent[with_tangent:] = np.nan, np.nan
    return PointsWithTangents(xy, xyz, direction, tangent, np.full(count, 0.5), np.full(count, directed))


def assert_true(rotation: FloatArray, position: FloatArray, tolerance: float) -> None:
    np.testing.assert_allclose(position, POSITION, atol=500.0 * tolerance)
    np.testing.assert_allclose(rotation, ROTATION, atol=tolerance)


def test_three_points_are_told_apart_by_tangents() -> None:
    """Three points alone admit up to four orientations; two tangents leave one."""
    alone = [resect_with_tangents(C, seen(3, seed, 0)).ambiguous for seed in range(12)]
    assert any(alone)
    for seed in range(12):
        found = resect_with_tangents(C, seen(3, seed, 2))
        assert not found.ambiguous
        assert_true(found.rotation, found.position, 1e-6)


def test_two_points_with_tangents_are_enough_or_ambiguous() -> None:
    """Never a guess: where it is not called ambiguous, it is the truth."""
    unique = 0
    for seed in range(40):
        try:
            found = resect_with_tangents(C, seen(2, seed, 2, directed=True))
        except ResectionError:
            continue
        if not found.ambiguous:
            assert_true(found.rotation, found.position, 1e-6)
            unique += 1
    assert 5 <= unique < 40


@pytest.mark.parametrize("wrong", [0.3, 0.4])
def test_wrong_points_and_tangents(wrong: float) -> None:
    points = seen(20, 5, 10)
    rng = np.random.default_rng(6)
    bad = rng.choice(20, round(wrong * 20), replace=False)
    xy = points.photo_xy + rng.normal(0.0, 0.005, (20, 2))
    xy[bad] = rng.uniform(-100.0, 100.0, (len(bad), 2))
    found = resect_with_tangents(C, replace(points, photo_xy=xy))
    assert found.n_inliers == 20 - len(bad)
    assert_true(found.rotation, found.position, 1e-3)


def test_too_little_says_so() -> None:
    with pytest.raises(ResectionError, match="too few points"):
        resect_with_tangents(C, seen(2, 1, 1))


def with_tangents(every: int) -> tuple[Network, FloatArray, FloatArray]:
    """The six-image block without orientations; exact locations and directions on the control splines."""
    network, truth = simulate_block("six-image", 3)
    eop = truth.eop
    rotation = rotation_object_from_photo(eop[:, :3])
    control = np.array([curve.role == "control" for curve in network.curves])
    observed = network.curve_observations
    located = np.where(control[observed.curve], truth.locations, np.nan)
    rows = np.flatnonzero(control[observed.curve])[::every]
    prepared = prepare(network)
    coefficients = np.vstack(
        [b.coefficients_from_values(v) for b, v in zip(prepared.curves.bases, truth.curves, strict=True)]
    )
    curve, u, image = observed.curve[rows], truth.locations[rows], observed.image[rows]
    xyz, rate = prepared.curves.evaluate(coefficients, curve, u, (0, 1))
    p = np.einsum("nji,nj->ni", rotation[image], xyz - eop[image, 3:])
    t = np.einsum("nji,nj->ni", rotation[image], rate)
    flow = t[:, :2] - p[:, :2] / p[:, 2:] * t[:, 2:]
    angle = np.arctan2(flow[:, 1], flow[:, 0]) + np.random.default_rng(4).normal(0.0, 0.005, len(rows))
    count = len(rows)
    tangents = Tangents(rows, angle, np.full(count, 0.005), np.zeros(count, dtype=bool))
    images = network.images
    unknown = replace(
        images, rotation=np.full_like(images.rotation, np.nan), position=np.full_like(images.position, np.nan)
    )
    network = replace(
        network, images=unknown, tangents=tangents, curve_observations=replace(observed, location=located)
    )
    return network, rotation, eop[:, 3:]


def test_a_network_is_oriented_from_located_points_on_control_curves() -> None:
    network, rotation, position = with_tangents(5)
    found = approximate_orientations(network)
    assert found.unresolved == {} and len(found.resolved) == 6
    assert np.abs(found.position - position).max() < 1.0
    assert np.abs(found.rotation - rotation).max() < 3e-3
    result = adjust(network)
    assert np.abs(result.images.eop[:, 3:] - position).max() < 0.5


def test_two_tangents_an_image() -> None:
    """Nothing but two located points with tangents: an orientation near the truth, or the reason why not."""
    network, _, position = with_tangents(5)
    observed, kept = network.curve_observations, []
    for image in range(6):
        rows = network.tangents.point[observed.image[network.tangents.point] == image]
        kept += [rows[0], rows[-1]]
    chosen = np.isin(network.tangents.point, kept)
    location = np.where(np.isin(np.arange(len(observed)), kept), observed.location, np.nan)
    network = replace(
        network,
        tangents=select_rows(network.tangents, np.flatnonzero(chosen)),
        curve_observations=replace(observed, location=location),
    )
    found = approximate_orientations(network)
    assert len(found.resolved) + len(found.unresolved) == 6
    for reason in found.unresolved.values():
        assert "2 points, 2 with tangents, admit several orientations" in reason
    for image in found.resolved:
        # tangents of a flat scene tell a tilt to 0.005 rad / slope only
        assert np.linalg.norm(found.position[image] - position[image]) < 150.0


def test_excluded_points_are_no_sights() -> None:
    network = with_tangents(1)[0]
    observed = network.curve_observations
    every = LocatedSights(network).image
    out = np.zeros(len(observed), dtype=bool)
    out[np.flatnonzero(np.isfinite(observed.location))[::2]] = True
    kept = LocatedSights(replace(network, curve_observations=replace(observed, excluded=out))).image
    assert len(every) > 20 and len(kept) == len(every) // 2
