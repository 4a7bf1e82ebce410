"""Forward intersection: exact, best in the image, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.approximation.intersection import Intersections, intersect_points
from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, IntArray

C = 150.0
POSITION = np.array([[0.0, 0.0, 500.0], [200.0, 10.0, 510.0], [100.0, 250.0, 490.0]])
ROTATION = rotation_object_from_photo(np.array([[0.01, 0.02, 0.1], [-0.03, 0.0, 0.0], [0.0, 0.05, 3.0]]))


def rays(points: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Every point in every image: point, image, photo coordinates."""
    point = np.repeat(np.arange(len(points)), len(POSITION))
    image = np.tile(np.arange(len(POSITION)), len(points))
    photo = project(np.full(len(point), C), ROTATION[image], POSITION[image], points[point])
    return point, image, photo


def intersect(point: IntArray, image: IntArray, photo: FloatArray, count: int) -> Intersections:
    return intersect_points(point, count, np.full(len(point), C), photo, ROTATION[image], POSITION[image])


def test_exact_rays_meet_in_the_points() -> None:
    points = np.random.default_rng(1).uniform(-100.0, 200.0, (50, 3)) * [1.0, 1.0, 0.2]
    found = intersect(*rays(points), count=50)
    np.testing.assert_allclose(found.xyz, points, atol=1e-9)
    assert not found.weak.any()
    assert (found.rays == 3).all()


def test_the_result_is_the_least_squares_one_in_the_image() -> None:
    """At the minimum the image residuals are orthogonal to the derivative; a 1 mm step shows a rise."""
    points = np.random.default_rng(2).uniform(-100.0, 200.0, (20, 3)) * [1.0, 1.0, 0.2]
    point, image, photo = rays(points)
    photo = photo + np.random.default_rng(3).normal(0.0, 0.02, photo.shape)
    found = intersect(point, image, photo, 20).xyz

    def cost(xyz: FloatArray) -> FloatArray:
        error = project(np.full(len(point), C), ROTATION[image], POSITION[image], xyz[point]) - photo
        return np.bincount(point, np.sum(error**2, axis=1)).astype(np.float64)

    for axis in np.eye(3):
        assert (cost(found + 1e-3 * axis) > cost(found)).all()
        assert (cost(found - 1e-3 * axis) > cost(found)).all()


def test_one_ray_is_none() -> None:
    point, image, photo = rays(np.zeros((2, 3)))
    keep = (point == 0) | (image == 1)
    found = intersect(point[keep], image[keep], photo[keep], 3)
    assert np.isfinite(found.xyz[0]).all()
    assert np.isnan(found.xyz[1:]).all()
    assert found.rays.tolist() == [3, 1, 0]


def test_parallel_rays_and_small_angles() -> None:
    position = np.array([[0.0, 0.0, 500.0], [0.2, 0.0, 500.0], [9.0, 0.0, 500.0]])  # base 0.2 m and 9 m
    photo = project(np.full(3, C), np.broadcast_to(np.eye(3), (3, 3, 3)), position, np.zeros((1, 3)))
    rotation = np.broadcast_to(np.eye(3), (4, 3, 3))
    point, image = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 2])
    found = intersect_points(point, 2, np.full(4, C), photo[image], rotation, position[image])
    assert np.isnan(found.xyz[0]).all()  # 0.02 degrees
    np.testing.assert_allclose(found.xyz[1], 0.0, atol=1e-7)
    assert found.weak.tolist() == [False, True]
    assert found.angle[1] == pytest.approx(np.arctan2(9.0, 500.0), rel=1e-6)


def test_a_point_behind_a_camera_is_none() -> None:
    """Two rays that diverge downwards meet above the cameras."""
    position = np.array([[0.0, 0.0, 500.0], [100.0, 0.0, 500.0]])
    photo = np.array([[-30.0, 0.0], [30.0, 0.0]])
    rotation = np.broadcast_to(np.eye(3), (2, 3, 3))
    found = intersect_points(np.zeros(2, dtype=np.int64), 1, np.full(2, C), photo, rotation, position)
    assert np.isnan(found.xyz).all()


def test_rays_of_unoriented_images_are_ignored() -> None:
    point, image, photo = rays(np.zeros((1, 3)))
    position = POSITION[image].copy()
    position[2] = np.nan
    found = intersect_points(point, 1, np.full(3, C), photo, ROTATION[image], position)
    assert found.rays.tolist() == [2]
    np.testing.assert_allclose(found.xyz[0], 0.0, atol=1e-9)
