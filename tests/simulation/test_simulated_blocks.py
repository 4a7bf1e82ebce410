"""Simulated blocks: exact without noise, honest with it, determined where they should be."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import project, project_with_jacobian
from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.simulation.catalogue import KINDS
from splinebba_cli.simulation.six_image_block import SCENES, simulate_block
from splinebba_cli.simulation.truth import Truth, at_truth

EXACT = [
    kind for kind in SCENES if kind != "circle-three-ways"
]  # one of its curves only approximates the truth
DETERMINED = [kind for kind in SCENES if kind != "six-image-singular"]


def curve_points(network: Network) -> tuple[FloatArray, FloatArray]:
    """Object points (n, 3) and tangents (n, 3) at the locations of the network."""
    seen = network.curve_observations
    xyz, tangent = np.empty((len(seen), 3)), np.empty((len(seen), 3))
    for index, curve in enumerate(network.curves):
        basis = basis_of(curve)
        rows = np.flatnonzero(seen.curve == index)
        coefficients = basis.coefficients_from_values(curve.values)
        xyz[rows] = basis.evaluate(seen.location[rows], coefficients)
        tangent[rows] = basis.evaluate(seen.location[rows], coefficients, 1)
    return xyz, tangent


def residuals(network: Network) -> FloatArray:
    """Measured - computed photo coordinates of curves and points, (n, 2) mm, at the values of the network."""
    curves, points, images = network.curve_observations, network.point_observations, network.images
    image = np.concatenate([curves.image, points.image])
    xyz = np.vstack([curve_points(network)[0], network.points.xyz[points.point]])
    c = np.full(len(image), network.cameras[0].principal_distance_mm)
    return np.vstack([curves.photo_xy, points.photo_xy]) - project(
        c, images.rotation[image], images.position[image], xyz
    )


@pytest.mark.parametrize("kind", EXACT)
def test_without_noise_the_truth_fits_exactly(kind: str) -> None:
    network, truth = simulate_block(kind, seed=3, noise_um=0.0)
    assert np.abs(residuals(at_truth(network, truth))).max() < 1e-11
    for curve, values in zip(network.curves, truth.curves, strict=True):
        known = np.isfinite(curve.sigma)
        np.testing.assert_array_equal(curve.values[known], values[known])
    known = np.isfinite(network.points.sigma)
    np.testing.assert_array_equal(network.points.xyz[known], truth.points[known])
    assert (network.curve_observations.sigma == 0.005).all()


@pytest.mark.parametrize("kind", EXACT)
def test_noise_has_the_stated_size(kind: str) -> None:
    network, truth = simulate_block(kind, seed=4, noise_um=8.0)
    ratio = residuals(at_truth(network, truth)) / 0.008
    # mean square of n standard normals: 1 with standard deviation sqrt(2 / n)
    assert abs(np.mean(ratio**2) - 1.0) < 4.0 * np.sqrt(2.0 / ratio.size)
    assert (network.curve_observations.sigma == 0.008).all()


def test_given_values_carry_their_errors() -> None:
    network, truth = simulate_block("strip", seed=5)
    prior = (network.images.prior - truth.eop) / network.images.prior_sigma
    assert 0.4 < np.sqrt(np.mean(prior**2)) < 1.6  # 30 values
    known = np.isfinite(network.points.sigma)
    assert (network.points.xyz[known] != truth.points[known]).all()


def test_seeds() -> None:
    """The same seed repeats everything; another one draws other noise and starts at the same places."""
    first, truth = simulate_block("six-image", seed=1)
    again, _ = simulate_block("six-image", seed=1)
    other, other_truth = simulate_block("six-image", seed=2)
    np.testing.assert_array_equal(first.curve_observations.photo_xy, again.curve_observations.photo_xy)
    np.testing.assert_array_equal(first.images.rotation, again.images.rotation)
    np.testing.assert_array_equal(truth.locations, other_truth.locations)
    assert (first.curve_observations.photo_xy != other.curve_observations.photo_xy).all()
    assert (first.images.position != other.images.position).all()


def test_starts_stay_within_their_limits() -> None:
    network, truth = simulate_block(
        "six-image", seed=6, start_position_m=4.0, start_angle_deg=0.5, start_knots_m=2.0
    )
    position = np.abs(network.images.position - truth.eop[:, 3:])
    angle = np.degrees(np.abs(angles_from_rotation(network.images.rotation) - truth.eop[:, :3]))
    angle = np.minimum(angle, 360.0 - angle)
    assert 2.0 < position.max() <= 4.0
    assert 0.25 < angle.max() <= 0.5
    free = np.concatenate([np.isinf(c.sigma).ravel() for c in network.curves])
    knots = np.concatenate(
        [(c.values - t).ravel() for c, t in zip(network.curves, truth.curves, strict=True)]
    )
    assert 1.0 < np.abs(knots[free]).max() <= 2.0


@pytest.mark.parametrize("kind", EXACT)
def test_every_image_measures_at_its_own_places_inside_the_format(kind: str) -> None:
    network, truth = simulate_block(kind, noise_um=0.0)
    half = 0.5 * np.array(network.cameras[0].format_mm)
    assert (np.abs(network.curve_observations.photo_xy) <= half + 1e-6).all()
    for curve in range(len(network.curves)):
        u = truth.locations[network.curve_observations.curve == curve]
        assert len(np.unique(np.round(u, 9))) == len(u)


def test_amount_of_measurements() -> None:
    """At least 25 points for every spline and image that sees it; every free spline in two images or more."""
    for kind in DETERMINED:
        network, _ = simulate_block(kind)
        seen = network.curve_observations
        table = np.zeros((len(network.curves), len(network.images.ids)), dtype=int)
        np.add.at(table, (seen.curve, seen.image), 1)
        assert table[table > 0].min() >= 25
        assert ((table > 0).sum(axis=1) >= 2).all()
        rays = np.bincount(network.point_observations.point, minlength=len(network.points.ids))
        assert (rays >= 2).all()


def test_roles() -> None:
    network, _ = simulate_block("six-image")
    roles = [curve.role for curve in network.curves]
    assert {"control", "partial", "tie"} == set(roles)
    assert any(curve.closed for curve in network.curves)
    assert all((c.sigma == 0.0).all() for c in network.curves if c.role == "control")
    partial = next(c for c in network.curves if c.role == "partial")
    assert (partial.sigma == 0.0).any() and np.isinf(partial.sigma).any()
    mixed, _ = simulate_block("six-image-mixed")
    assert {"partial", "tie", "check"} == {curve.role for curve in mixed.curves}
    assert {"control", "tie", "check"} == set(mixed.points.role)


def test_an_unknown_kind_is_refused_with_the_known_ones() -> None:
    with pytest.raises(KeyError, match="six-image-mixed"):
        simulate_block("nonsense")
    assert set(KINDS) == set(SCENES)


def across_design(network: Network, truth: Truth) -> FloatArray:
    """Whitened design (n, 6 m) of the equations across the curve with respect to orientations alone."""
    network = at_truth(network, truth)
    seen, images = network.curve_observations, network.images
    xyz, tangent = curve_points(network)
    c = np.full(len(seen), network.cameras[0].principal_distance_mm)
    _, jacobian = project_with_jacobian(c, images.rotation[seen.image], images.position[seen.image], xyz)
    along = np.einsum("nij,nj->ni", jacobian.object_xyz, tangent)
    normal = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1)[:, None]
    rows = np.einsum("ni,nij->nj", normal, jacobian.orientation) / seen.sigma[:, :1]
    design = np.zeros((len(seen), 6 * len(images.ids)))
    for i in range(len(images.ids)):
        design[seen.image == i, 6 * i : 6 * i + 6] = rows[seen.image == i]
    return design


def test_one_segment_cannot_determine_six_orientations() -> None:
    """24 equations across the curve, 36 unknowns (Lee's table 5.7, whose claim rests on arc lengths)."""
    design = across_design(*simulate_block("six-image-singular"))
    assert design.shape == (24, 36)
    assert np.linalg.matrix_rank(design) <= 24


def test_control_splines_alone_determine_every_image_of_the_block() -> None:
    """Predicted sigma of each orientation from fixed splines only: decimetres, not kilometres."""
    network, truth = simulate_block("six-image")
    control = [i for i, curve in enumerate(network.curves) if curve.role == "control"]
    design = across_design(network, truth)[np.isin(network.curve_observations.curve, control)]
    sigma = np.sqrt(np.diag(np.linalg.inv(design.T @ design))).reshape(6, 6)
    assert sigma[:, 3:].max() < 0.5
    assert np.degrees(sigma[:, :3]).max() < 0.1
