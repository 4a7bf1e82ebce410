"""Collinearity equations: geometry, and Jacobians against the complex step."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import photo_frame_xyz, project, project_with_jacobian
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray
from tests.core.observations import complex_step
from tests.core.observations.random_network import camera_of

COUNT = 40


def configurations(seed: int = 2) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Principal distances, rotations of any kind, stations and points in front of them."""
    generator = np.random.default_rng(seed)
    c = generator.uniform(5.0, 300.0, COUNT)
    rotation = rotation_object_from_photo(generator.uniform(-np.pi, np.pi, (COUNT, 3)))
    position = generator.normal(0.0, 500.0, (COUNT, 3))
    inside = generator.uniform([-0.8, -0.8, -1.0], [0.8, 0.8, -0.99], (COUNT, 3)) * generator.uniform(
        1.0, 2000.0, (COUNT, 1)
    )
    return c, rotation, position, position + np.einsum("nij,nj->ni", rotation, inside)


def test_a_camera_that_looks_down() -> None:
    """x to the right, y up, c w / u: a point 30 m east and 20 m north of the nadir, 300 m below, c = 150 mm."""
    xy = project(
        np.array([150.0]), np.eye(3)[None], np.array([[5.0, 6.0, 300.0]]), np.array([[35.0, 26.0, 0.0]])
    )
    np.testing.assert_allclose(xy, [[15.0, 10.0]], rtol=1e-14)


def test_what_lies_behind_the_camera_has_no_image() -> None:
    points = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 1.0, 2.0], [0.0, 0.0, -1.0]])
    many = (np.full(4, 100.0), np.broadcast_to(np.eye(3), (4, 3, 3)), np.zeros((4, 3)), points)
    for xy in (project(*many), project_with_jacobian(*many)[0]):
        np.testing.assert_array_equal(np.isnan(xy).all(axis=1), [True, True, True, False])


def test_frames_turn_with_the_rotation() -> None:
    """R turns photo axes into object axes: an object point R p + X0 has photo frame coordinates p."""
    _, rotation, position, xyz = configurations()
    p = photo_frame_xyz(rotation, position, xyz)
    assert (p[:, 2] < 0.0).all()
    np.testing.assert_allclose(np.einsum("nij,nj->ni", rotation, p) + position, xyz, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("seed", [2, 3])
def test_projection_and_jacobians_equal_the_complex_step(seed: int) -> None:
    c, rotation, position, xyz = configurations(seed)
    xy, found = project_with_jacobian(c, rotation, position, xyz)
    np.testing.assert_allclose(project(c, rotation, position, xyz), xy, rtol=1e-14)
    for k in range(COUNT):
        camera = camera_of(0, np.random.default_rng(0))
        object.__setattr__(camera, "principal_distance_mm", float(c[k]))

        def image(x: complex_step.Array, k: int = k, camera=camera) -> complex_step.Array:
            turned = complex_step.turned(rotation[k], x[:3])
            return complex_step.photo_xy(camera, turned, x[3:6], x[6:])

        x = np.concatenate([np.zeros(3), position[k], xyz[k]])
        exact = complex_step.jacobian(image, x)
        np.testing.assert_allclose(xy[k], np.real(image(x)), rtol=1e-11)
        analytic = np.hstack([found.orientation[k], found.object_xyz[k]])
        for part in (slice(0, 3), slice(3, 6), slice(6, 9)):
            size = np.abs(exact[:, part]).max()
            np.testing.assert_allclose(analytic[:, part], exact[:, part], rtol=0.0, atol=1e-9 * size)
