"""Resection of one image: exact, flat control, wrong points, ambiguity, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.approximation.resection import ResectionError, resect
from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray

C = 150.0
ROTATION = rotation_object_from_photo(np.array([0.05, -0.08, 2.0]))
POSITION = np.array([120.0, -60.0, 480.0])


def ground(count: int, relief: float, seed: int = 3) -> FloatArray:
    return np.random.default_rng(seed).uniform([-200.0, -200.0, -relief], [300.0, 200.0, relief], (count, 3))


def picture(points: FloatArray) -> FloatArray:
    count = len(points)
    return project(np.full(count, C), np.broadcast_to(ROTATION, (count, 3, 3)), POSITION[None], points)


@pytest.mark.parametrize("relief", [60.0, 1.0, 0.0])
@pytest.mark.parametrize("count", [5, 12, 60])
def test_exact_points_give_the_orientation_back(count: int, relief: float) -> None:
    points = ground(count, relief)
    found = resect(C, picture(points), points)
    np.testing.assert_allclose(found.position, POSITION, atol=1e-6)
    np.testing.assert_allclose(found.rotation, ROTATION, atol=1e-8)
    assert found.n_inliers == count
    assert found.rms_mm < 1e-9


def test_large_coordinates_cost_no_digits() -> None:
    points, shift = ground(10, 20.0), np.array([7_672_000.0, 512_000.0, 0.0])
    found = resect(C, picture(points), points + shift)
    np.testing.assert_allclose(found.position - shift, POSITION, atol=1e-5)


def test_wrong_points_are_left_out() -> None:
    points = ground(14, 30.0)
    photo = picture(points) + np.random.default_rng(5).normal(0.0, 0.005, (14, 2))
    photo[[2, 7, 11]] += [[12.0, -3.0], [-2.0, 8.0], [1.0, 1.0]]
    found = resect(C, photo, points)
    assert 9 <= found.n_inliers <= 11
    assert np.linalg.norm(found.position - POSITION) < 1.0


def test_rms_measures_the_noise() -> None:
    points = ground(200, 30.0)
    found = resect(C, picture(points) + np.random.default_rng(6).normal(0.0, 0.005, (200, 2)), points)
    assert found.rms_mm == pytest.approx(0.005, rel=0.15)  # 394 degrees of freedom: sigma of the rms is 3.6 %


def test_three_points_are_ambiguous_and_a_rough_orientation_decides() -> None:
    points = np.array([[-100.0, -50.0, 0.0], [180.0, 20.0, 3.0], [10.0, 190.0, -2.0]])
    position = np.array([20.0, 40.0, 480.0])
    photo = project(np.full(3, C), np.broadcast_to(np.eye(3), (3, 3, 3)), position[None], points)
    assert resect(C, photo, points).ambiguous
    rough = rotation_object_from_photo(np.array([0.02, 0.02, 0.03])), position + [10.0, -10.0, 5.0]
    found = resect(C, photo, points, rough)
    np.testing.assert_allclose(found.position, position, atol=1e-5)
    assert found.ambiguous


def test_the_mirror_image_behind_the_camera_is_no_solution() -> None:
    """Flat ground seen from below with all points behind the camera projects to the same image."""
    points, position = ground(8, 0.0), np.array([30.0, 10.0, 480.0])
    photo = project(np.full(8, C), np.broadcast_to(np.eye(3), (8, 3, 3)), position[None], points)
    mirror = np.diag([-1.0, -1.0, 1.0]), position * np.array([1.0, 1.0, -1.0])
    found = resect(C, photo, points, mirror)
    np.testing.assert_allclose(found.position, position, atol=1e-6)
    assert not found.ambiguous


def test_more_points_are_not_ambiguous() -> None:
    points = ground(6, 30.0)
    assert not resect(C, picture(points), points).ambiguous


def test_collinear_points_are_refused() -> None:
    points = np.linspace(0.0, 1.0, 6)[:, None] * np.array([200.0, 100.0, 10.0])
    with pytest.raises(ResectionError, match="collinear") as caught:
        resect(C, picture(points), points)
    assert caught.value.reason == "collinear points"


def test_two_points_and_nan_rows_are_refused() -> None:
    points = ground(4, 10.0)
    photo = picture(points)
    points[:2] = np.nan
    with pytest.raises(ResectionError) as caught:
        resect(C, photo, points)
    assert caught.value.reason == "too few points"
