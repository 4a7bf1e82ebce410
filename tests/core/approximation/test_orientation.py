"""Approximate orientations of a network: chains of images, refusals, and the block of Strasbourg."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.approximation.orientation import approximate_orientations
from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import measured_photo_xy
from splinebba_cli.core.camera.rotation import angles_from_rotation, rotation_object_from_photo
from splinebba_cli.core.network import Camera, FloatArray, Images, Network, PointObservations, Points, Role
from tests import reference_data
from tests.curve_residuals import residuals_across

CAMERA = Camera(
    "c", 150.0, np.array([0.02, -0.03]), np.array([1e-8, 0.0, 0.0]), np.zeros(2), np.array([1e-4, 0.0])
)


def strip(
    images: int = 5, points: int = 150, control: int = 6
) -> tuple[Network, FloatArray, FloatArray, FloatArray]:
    """A strip with control below the first image alone; returns truth: rotation, position, xyz."""
    rng = np.random.default_rng(11)
    position = np.column_stack(
        [200.0 * np.arange(images), rng.normal(0, 5, images), rng.normal(500, 5, images)]
    )
    rotation = rotation_object_from_photo(rng.normal(0.0, 0.03, (images, 3)))
    xyz = rng.uniform([-250.0, -250.0, -20.0], [200.0 * images + 50.0, 250.0, 20.0], (points, 3))
    xyz[:control] = rng.uniform([-260.0, -200.0, -20.0], [-200.0, 200.0, 20.0], (control, 3))
    image = np.repeat(np.arange(images), points)
    point = np.tile(np.arange(points), images)
    photo = project(np.full(len(image), 150.0), rotation[image], position[image], xyz[point])
    inside = (np.abs(photo) < 115.0).all(axis=1)
    image, point, photo = image[inside], point[inside], measured_photo_xy(CAMERA, photo[inside])
    role: list[Role] = ["control" if i < control else "tie" for i in range(points)]
    sigma = np.where(np.arange(points)[:, None] < control, 0.02, np.inf) * np.ones(3)
    given = np.where(np.isfinite(sigma), xyz, np.nan)
    nan = np.full((images, 6), np.nan)
    network = Network(
        np.zeros(3),
        (CAMERA,),
        Images(
            tuple(str(i) for i in range(images)),
            np.zeros(images, dtype=np.int64),
            np.full((images, 3, 3), np.nan),
            np.full((images, 3), np.nan),
            reference_data.omega_phi_kappa(images),
            nan,
            np.full((images, 6), np.inf),
        ),
        Points(tuple(str(i) for i in range(points)), tuple(role), given, sigma, np.full((points, 3), np.nan)),
        (),
        PointObservations(image, point, photo, np.full((len(image), 2), 0.005)),
        reference_data.no_curve_observations(),
    )
    return network, rotation, position, xyz


def test_orientation_spreads_from_control_through_tie_points() -> None:
    """Control under one image; a second image is given; the others follow from intersected points."""
    network, rotation, position, xyz = strip()
    images = network.images
    images.rotation[1], images.position[1] = rotation[1], position[1]
    found = approximate_orientations(network)
    assert found.unresolved == {}
    assert set(found.resolved) == {0, 2, 3, 4}
    np.testing.assert_allclose(found.position, position, atol=1e-4)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-6)
    rays = np.bincount(network.point_observations.point, minlength=len(xyz))
    np.testing.assert_allclose(found.xyz[rays >= 2], xyz[rays >= 2], atol=1e-3)


def test_unresolved_images_say_why() -> None:
    network, _, position, _ = strip()
    found = approximate_orientations(network)
    np.testing.assert_allclose(found.position[0], position[0], atol=1e-5)
    assert set(found.resolved) == {0}
    assert set(found.unresolved) == {1, 2, 3, 4}
    assert all("known coordinates" in reason for reason in found.unresolved.values())
    assert np.isnan(found.position[4]).all()


@pytest.mark.parametrize(("given_role", "sigma_m"), [("check", 0.02), ("check", np.inf), ("control", np.inf)])
def test_check_points_and_free_points_do_not_orient(given_role: Role, sigma_m: float) -> None:
    network = strip()[0]
    points = network.points
    role: tuple[Role, ...] = tuple(given_role if r == "control" else r for r in points.role)
    checked = replace(points, role=role, sigma=np.full_like(points.sigma, sigma_m))
    found = approximate_orientations(replace(network, points=checked))
    assert found.resolved == {}
    assert np.isnan(found.position).all()
    assert np.isnan(found.xyz[6:]).all()


def test_a_complete_prior_serves_as_orientation() -> None:
    network, rotation, position, _ = strip()
    network.images.prior[1] = np.concatenate([angles_from_rotation(rotation[1]), position[1]])
    found = approximate_orientations(network)
    assert found.unresolved == {} and 1 not in found.resolved
    np.testing.assert_allclose(found.rotation[1], rotation[1], atol=1e-12)


def test_given_values_are_not_touched() -> None:
    network, rotation, position, _ = strip()
    network.images.rotation[:], network.images.position[:] = rotation, position + 1.0
    found = approximate_orientations(network)
    assert found.resolved == {}
    np.testing.assert_array_equal(found.position, position + 1.0)
    np.testing.assert_array_equal(found.xyz[:6], network.points.xyz[:6])


def test_strasbourg_from_its_control_points() -> None:
    """Real block without orientations (DBAT 0.9.2): 6 to 11 nearly coplanar control points an image.

    Control and image noise (0.5 px) let a single resection deviate by sigmas of some 0.7 m and 0.03 degrees.
    """
    network = reference_data.strasbourg_points_network(approximate=False)
    assert len(network.point_observations) == 1196 and len(network.points.ids) == 381
    report = reference_data.strasbourg_report()
    _, position = reference_data.strasbourg_orientation(report.eop)
    found = approximate_orientations(network)
    assert found.unresolved == {}
    assert np.abs(found.position - position).max() < 3.0
    difference = np.degrees(angles_from_rotation(found.rotation)) - report.eop[:, :3]
    assert np.abs(difference).max() < 0.1
    assert np.isfinite(found.xyz).all()
    checks = [network.points.ids.index(id) for id in reference_data.STRASBOURG_CHECKS]
    assert 0.0 < np.abs(found.xyz[checks] - network.points.xyz[checks]).max() < 3.0


@pytest.mark.parametrize(("first", "rms"), [(1.0, 0.669), (0.0, 1.13)])
def test_pixel_convention_of_the_strasbourg_curves(
    first: float, rms: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the first pixel centred at (1, 1) the reference curves fit to the published 0.67 px."""
    monkeypatch.setattr(reference_data, "STRASBOURG_CURVE_FIRST_PIXEL", first)
    network = reference_data.strasbourg_curves_network()
    assert (len(network.curves), len(network.curve_observations)) == (30, 5727)
    residual = residuals_across(network) / reference_data.STRASBOURG_PIXEL_MM
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(rms, abs=0.01)


def test_frames_of_the_vase() -> None:
    """Cameras turned from the computer-vision frame see the reference curves within the published 0.50 px."""
    network = reference_data.vase_network()
    assert (len(network.curves), len(network.curve_observations)) == (12, 5932)
    residual = residuals_across(network) / reference_data.VASE_PIXEL_MM
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(0.495, abs=0.01)
