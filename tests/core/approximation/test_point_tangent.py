"""Orientation from two points with tangents: the truth among all solutions, degenerate cases, noise, real geometry."""

from __future__ import annotations

import gzip

import numpy as np
import pytest

from splinebba_cli.core.approximation.point_tangent import (
    PointTangentSolutions,
    chord_frames,
    orient_from_point_tangents,
    tangent_equations,
)
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray, IntArray
from tests.reference_data import reference_dir

C = 150.0


def seen_by(
    rotation: FloatArray, position: FloatArray, points: FloatArray, tangents: FloatArray, distance: float = C
) -> tuple[FloatArray, FloatArray]:
    """Rays (k, 2, 3) and unit directions (k, 2, 2) in the sense of the tangents."""
    photo = np.einsum("kji,kpj->kpi", rotation, points - position[:, None])
    rays = photo * (-distance / photo[:, :, 2:])
    turned = np.einsum("kji,kpj->kpi", rotation, tangents)
    flow = turned[:, :, :2] - rays[:, :, :2] / rays[:, :, 2:] * turned[:, :, 2:]
    return rays, flow / np.linalg.norm(flow, axis=2, keepdims=True)


def random_cameras(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    rotation = rotation_object_from_photo(rng.uniform([-0.4, -0.4, -3.1], [0.4, 0.4, 3.1], (count, 3)))
    return rotation, rng.normal(0.0, 100.0, (count, 3)) + [0.0, 0.0, 500.0]


def random_pairs(count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    points = rng.uniform([-250.0, -250.0, -40.0], [250.0, 250.0, 40.0], (count, 2, 3))
    return points, rng.normal(size=(count, 2, 3))


def smallest_error(
    found: PointTangentSolutions, rotation: FloatArray, position: FloatArray, scale: float = 500.0
) -> FloatArray:
    """Of the best solution of every pair, in lengths; infinite where a pair has none."""
    error = np.full(len(rotation), np.inf)
    away = np.linalg.norm(found.position - position[found.pair], axis=1)
    away += scale * np.linalg.norm(found.rotation - rotation[found.pair], axis=(1, 2))
    np.minimum.at(error, found.pair, away)
    return error


def test_the_true_orientation_is_among_the_solutions() -> None:
    rotation, position = random_cameras(4000, 1)
    points, tangents = random_pairs(4000, 2)
    found = orient_from_point_tangents(*seen_by(rotation, position, points, tangents), points, tangents)
    error = smallest_error(found, rotation, position)
    # a nearly double solution loses half the digits; one that is double to rounding may be lost
    assert np.quantile(error, 0.98) < 1e-8
    assert np.count_nonzero(error > 1e-2) <= 2


def test_every_solution_sees_points_and_tangents() -> None:
    rotation, position = random_cameras(4000, 3)
    points, tangents = random_pairs(4000, 4)
    rays, directions = seen_by(rotation, position, points, tangents)
    found = orient_from_point_tangents(rays, directions, points, tangents)
    local = np.einsum("sji,spj->spi", found.rotation, points[found.pair] - found.position[:, None])
    assert (local[:, :, 2] < 0.0).all()
    again, flow = seen_by(found.rotation, found.position, points[found.pair], tangents[found.pair])
    np.testing.assert_allclose(again, rays[found.pair], atol=1e-8)
    along = np.sum(flow * directions[found.pair], axis=2)
    assert np.array_equal(along > 0.0, found.same_sense)
    # directions are ill-determined only where a tangent runs nearly along its ray
    assert np.quantile(np.abs(np.abs(along) - 1.0), 0.999) < 1e-12
    np.testing.assert_allclose(np.linalg.det(found.rotation), 1.0, atol=1e-12)


def test_all_solutions_are_found() -> None:
    """Their number is that of the roots of the trigonometric polynomial on the unit circle, without polishing."""
    rotation, position = random_cameras(300, 5)
    points, tangents = random_pairs(300, 6)
    rays, directions = seen_by(rotation, position, points, tangents)
    found = orient_from_point_tangents(rays, directions, points, tangents)
    frame, _ = chord_frames(rays / np.linalg.norm(rays, axis=2, keepdims=True), directions, points, tangents)
    angles = 2.0 * np.pi * np.arange(16) / 16.0
    count = np.bincount(found.pair, minlength=300)
    for pair in range(300):
        values = [_determinant(frame.m[pair], frame.t[pair], angle) for angle in angles]
        series = np.fft.fft(values) / 16.0
        roots = np.roots([series[k % 16] for k in range(4, -5, -1)])
        theta = np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-6])
        assert count[pair] == np.count_nonzero(np.abs(theta) < frame.width[pair])
    assert count.max() >= 4


def test_solutions_of_nearly_the_same_depth_that_differ_by_a_turn() -> None:
    """Two roots in theta that nearly coincide but belong to different turns about the chord: neither is lost."""
    rotation, position = random_cameras(30_000, 1)
    points, tangents = random_pairs(30_000, 2)
    rows = [18414, 20509]
    rays, directions = seen_by(rotation[rows], position[rows], points[rows], tangents[rows])
    found = orient_from_point_tangents(rays, directions, points[rows], tangents[rows])
    assert np.bincount(found.pair).tolist() == [5, 4]


def _determinant(m: FloatArray, t: FloatArray, theta: float) -> float:
    """F(theta) of one pair, written out independently: c^2 + s^2 - 1 times the squared determinant."""
    e = np.array([np.cos(theta), np.sin(theta)])
    across = np.array([-np.sin(theta), np.cos(theta)])
    rows = []
    for (p, q, r), (a, y, z) in zip(m, t, strict=True):
        h, g = e @ [p, q], across @ [p, q]
        rows.append((y * g + z * r, y * r - z * g, a * h))
    matrix = np.array(rows)[:, :2]
    adjugate = np.array([[matrix[1, 1], -matrix[0, 1]], [-matrix[1, 0], matrix[0, 0]]])
    turned = adjugate @ np.array(rows)[:, 2]
    return float(turned @ turned - np.linalg.det(matrix) ** 2)


def test_derivatives_of_the_tangent_equations() -> None:
    rotation, position = random_cameras(50, 7)
    points, tangents = random_pairs(50, 8)
    rays, directions = seen_by(rotation, position, points, tangents)
    frame, _ = chord_frames(rays / np.linalg.norm(rays, axis=2, keepdims=True), directions, points, tangents)
    theta, psi = np.random.default_rng(9).uniform(-1.0, 1.0, (2, 50))
    rate = tangent_equations(frame, theta, psi)[1]
    h = 1e-30
    by_theta = tangent_equations(frame, theta + 1j * h, psi)[0].imag / h
    by_psi = tangent_equations(frame, theta, psi + 1j * h)[0].imag / h
    np.testing.assert_allclose(rate, np.stack([by_theta, by_psi], axis=2), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("case", ["coplanar", "parallel", "flat scene"])
def test_tangents_in_one_plane_are_no_special_case(case: str) -> None:
    rotation, position = random_cameras(200, 10)
    points, tangents = random_pairs(200, 11)
    if case == "coplanar":
        tangents[:, 1] = tangents[:, 0] + 0.7 * (points[:, 1] - points[:, 0]) / 100.0
    if case == "parallel":
        tangents[:, 1] = -2.0 * tangents[:, 0]
    if case == "flat scene":
        points[:, :, 2] = tangents[:, :, 2] = 0.0
    found = orient_from_point_tangents(*seen_by(rotation, position, points, tangents), points, tangents)
    assert np.quantile(smallest_error(found, rotation, position), 0.95) < 1e-6


def test_symmetric_pairs_whose_solution_is_a_double_root() -> None:
    """Points, tangents and camera that are their own mirror images: F is even about the truth and only touches 0."""
    rng = np.random.default_rng(16)
    count = 60
    a, y, z = rng.uniform(50.0, 200.0, count), *rng.normal(0.0, 30.0, (2, count))
    points = np.stack([np.column_stack([sign * a, y, z]) for sign in (-1.0, 1.0)], axis=1)
    one = rng.normal(size=(count, 3))
    tangents = np.stack([one, one * [-1.0, 1.0, 1.0]], axis=1)
    angles = np.column_stack([rng.uniform(-0.4, 0.4, count), np.zeros((count, 2))])
    position = np.column_stack([np.zeros(count), rng.normal(0.0, 80.0, count), np.full(count, 500.0)])
    rotation = rotation_object_from_photo(angles)
    found = orient_from_point_tangents(*seen_by(rotation, position, points, tangents), points, tangents)
    error = smallest_error(found, rotation, position)
    assert np.quantile(error, 0.95) < 0.05  # a double root has half the digits


def test_tangents_that_say_nothing_give_no_solution() -> None:
    """Along the chord, or along the ray: infinitely many orientations, none is returned."""
    rotation, position = random_cameras(2, 12)
    points, tangents = random_pairs(2, 13)
    tangents[0, 0] = points[0, 1] - points[0, 0]
    rays, directions = seen_by(rotation, position, points, tangents)
    directions[1, 1] = np.nan  # its projection is a point
    found = orient_from_point_tangents(rays, directions, points, tangents)
    assert len(found.pair) == 0
    none = np.zeros((0, 2, 3))
    assert len(orient_from_point_tangents(none, np.zeros((0, 2, 2)), none, none).pair) == 0


def synthetic_pairs(count: int, seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, IntArray]:
    """Rays (px), directions, points and tangents (mm) of random pairs of frame 0, and the truth as 3 x 4 rows."""
    folder = reference_dir() / "synthcurves/turntable20"
    xyz, tangents = (_table(folder / f"crv-3D-{name}.txt.gz") for name in ("pts", "tgts"))
    camera = np.loadtxt(folder / "frame_0000.extrinsic")
    rotation = camera[:3].T @ np.diag(
        [1.0, -1.0, -1.0]
    )  # computer-vision axes to x right, y up, view along -z
    chosen = np.random.default_rng(seed).integers(20, len(xyz), (count, 2))
    chosen = chosen[np.linalg.norm(xyz[chosen[:, 0]] - xyz[chosen[:, 1]], axis=1) > 10.0]
    truth = np.column_stack([rotation, camera[3]])
    return xyz[chosen], tangents[chosen], truth, _table(folder / "frame_0000-pts-2D.txt.gz")[chosen], chosen


def _table(path) -> FloatArray:  # type: ignore[no-untyped-def]
    with gzip.open(path, "rt") as file:
        return np.loadtxt(file)


def test_synthetic_curves_exactly_and_with_half_a_pixel() -> None:
    """Fabbri & Kimia, IJCV 2016 (CC-BY): points and tangents of analytic curves, exact projections.

    The object fills 4 degrees of the field of view, so that half a pixel and 0.5 degrees turn into some degrees.
    """
    points, tangents, truth, pixel, _ = synthetic_pairs(1500, 14)
    count = len(points)
    rotation, position = np.tile(truth[:, :3], (count, 1, 1)), np.tile(truth[:, 3], (count, 1))
    focal, centre = (
        np.array([2900.4032342559799, 2900.2454199096264]),
        np.array([249.80449516746, -205.36322719]),
    )
    metric = (pixel - centre) / focal * np.array([1.0, -1.0]) * 2900.0
    rays, directions = seen_by(rotation, position, points, tangents, 2900.0)
    np.testing.assert_allclose(rays[:, :, :2], metric, atol=1e-5)
    found = orient_from_point_tangents(rays, directions, points, tangents)
    exact = smallest_error(found, rotation, position, 1000.0)
    assert np.quantile(exact, 0.9) < 1e-3  # mm
    rng = np.random.default_rng(15)
    rays[:, :, :2] += rng.normal(0.0, 0.5, (count, 2, 2))
    angle = np.arctan2(directions[:, :, 1], directions[:, :, 0]) + rng.normal(
        0.0, np.radians(0.5), (count, 2)
    )
    noisy = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    found = orient_from_point_tangents(rays, noisy, points, tangents)
    turned = np.full(count, np.inf)
    np.minimum.at(
        turned, found.pair, np.linalg.norm(found.rotation - truth[:, :3], axis=(1, 2)) / np.sqrt(2.0)
    )
    assert np.degrees(np.median(turned)) < 3.0
