"""Three-point orientation: every solution fits, the true one is among them, symmetric triangles too."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.approximation.three_points import orient_from_three_points
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray

C = 150.0


def random_views(count: int, seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Rays (k, 3, 3), object points (k, 3, 3) and the truth, for cameras about 500 m above random points."""
    rng = np.random.default_rng(seed)
    rotation = rotation_object_from_photo(rng.uniform([-0.4, -0.4, -3.1], [0.4, 0.4, 3.1], (count, 3)))
    position = rng.normal(0.0, 100.0, (count, 3)) + [0.0, 0.0, 500.0]
    points = rng.uniform([-250.0, -250.0, -40.0], [250.0, 250.0, 40.0], (count, 3, 3))
    return *rays_of(rotation, position, points), rotation, position


def rays_of(rotation: FloatArray, position: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    photo = np.einsum("kji,kpj->kpi", rotation, points - position[:, None])
    return photo * (-C / photo[:, :, 2:]), points


def test_the_true_orientation_is_among_the_solutions() -> None:
    rays, points, rotation, position = random_views(2000, 1)
    found = orient_from_three_points(rays, points)
    error = np.full(len(rays), np.inf)
    distance = np.linalg.norm(found.position - position[found.triplet], axis=1)
    distance += 500.0 * np.linalg.norm(found.rotation - rotation[found.triplet], axis=(1, 2))
    np.minimum.at(error, found.triplet, distance)
    # a double solution (dangerous cylinder) loses half the digits, so the largest error is no measure
    assert np.quantile(error, 0.95) < 1e-8
    assert error.max() < 0.05


def test_every_solution_projects_the_points_back() -> None:
    rays, points, _, _ = random_views(2000, 2)
    found = orient_from_three_points(rays, points)
    local = points[found.triplet] - found.position[:, None]
    photo = np.einsum("sji,spj->spi", found.rotation, local)
    error = -C * photo[:, :, :2] / photo[:, :, 2:] - rays[found.triplet, :, :2]
    worst = np.abs(error).max(axis=(1, 2))
    assert (photo[:, :, 2] < 0.0).all()
    assert np.quantile(worst, 0.95) < 1e-8
    np.testing.assert_allclose(np.linalg.det(found.rotation), 1.0, atol=1e-12)
    counts = np.bincount(found.triplet, minlength=len(rays))
    assert counts.min() >= 1 and counts.max() <= 4 and len(np.unique(counts)) > 2


def test_symmetric_triangle_below_the_camera() -> None:
    """Equilateral, camera on its axis: the classical quartic loses its leading coefficient there."""
    angles = np.radians([90.0, 210.0, 330.0])
    points = 100.0 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    rays, object_xyz = rays_of(np.eye(3)[None], np.array([[0.0, 0.0, 300.0]]), points[None])
    found = orient_from_three_points(rays, object_xyz)
    assert np.linalg.norm(found.position - [0.0, 0.0, 300.0], axis=1).min() < 1e-6


def test_isosceles_triangle() -> None:
    points = np.array([[-100.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 80.0, 5.0]])
    rays, object_xyz = rays_of(np.eye(3)[None], np.array([[0.0, 10.0, 400.0]]), points[None])
    found = orient_from_three_points(rays, object_xyz)
    assert np.linalg.norm(found.position - [0.0, 10.0, 400.0], axis=1).min() < 1e-6
