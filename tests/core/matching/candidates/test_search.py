"""All places of curves near measured points: none is lost, none is found twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.matching.candidates.curve_feet import _seen
from splinebba_cli.core.matching.candidates.piece_feet import PieceFeet
from splinebba_cli.core.matching.candidates.search import Candidates, find_candidates
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray
from tests.core.matching.scenes import (
    DISTANCE,
    curve,
    many_curves,
    minima_by_sampling,
    scene_of,
    tilted_images,
)

SAMPLES = 1500  # of a segment


def scene_with_points(seed: int, count: int, spread: float) -> tuple[Scene, FloatArray]:
    """Points beside curves and anywhere, with radii of their own."""
    g = np.random.default_rng(seed)
    rotation, position = tilted_images(seed)
    curves = many_curves(seed)
    image = g.integers(0, 3, count)
    scene = scene_of(curves, image, np.zeros((count, 2)), rotation, position)
    number = g.integers(0, len(curves), count)
    u = g.uniform(scene.curves.first[number], scene.curves.last[number])
    u[::9] = scene.curves.first[number[::9]]
    (xyz,) = scene.curves.evaluate(scene.coefficients, number, u)
    xy = project(np.full(count, DISTANCE), rotation[image], position[image], xyz)
    xy += g.normal(0.0, spread, xy.shape) * (np.arange(count) % 3 > 0)[:, None]
    lost = ~np.isfinite(xy).all(axis=1) | (np.abs(xy) > 80.0).any(axis=1)
    xy[lost] = g.uniform(-40.0, 40.0, (np.count_nonzero(lost), 2))
    return replace(scene, xy=xy), spread * 10.0 ** g.uniform(-0.5, 0.7, count)


@pytest.mark.parametrize(("seed", "spread"), [(0, 0.01), (1, 0.5), (2, 6.0)])
def test_all_minima_of_all_curves_are_found_once(seed: int, spread: float) -> None:
    scene, radius = scene_with_points(seed, 60, spread)
    found = find_candidates(scene, radius)
    for image, number in np.ndindex(3, len(scene.curves.bases)):
        expected = minima_by_sampling(scene, image, number, SAMPLES)
        for point, least in zip(np.flatnonzero(scene.image == image), expected, strict=True):
            rows = np.flatnonzero((found.point == point) & (found.curve == number))
            own = np.sort(np.linalg.norm(found.offset[rows], axis=1))
            if not scene.curves.has_location[number]:  # a single point is no curve
                assert not len(rows)
                continue
            least = least[least <= radius[point]]
            assert len(own) == len(least), (point, number, own, least)
            np.testing.assert_allclose(own, least, rtol=1e-9, atol=1e-9)


def test_what_a_candidate_says() -> None:
    """Offsets lead to the curve, tangents and speeds are its derivative, offsets are perpendicular but at ends."""
    scene, radius = scene_with_points(5, 200, 0.5)
    found = find_candidates(scene, radius)
    assert len(found) > 100
    assert (np.diff(found.point) >= 0).all()
    distance = np.linalg.norm(found.offset, axis=1)
    same = np.diff(found.point) == 0
    assert (np.diff(distance)[same] >= 0.0).all()
    assert (distance <= radius[found.point] * (1.0 + 1e-6)).all()
    step = 1e-6 * scene.curves.length[found.segment]
    xy = [_projected(scene, found, found.location + k * step) for k in (-1.0, 0.0, 1.0)]
    np.testing.assert_allclose(xy[1] - scene.xy[found.point], found.offset, atol=1e-9)
    segment, _ = scene.curves.locate(found.curve, found.location)
    plain = ~found.at_end & ~found.at_corner & (segment == found.segment)
    rate = (xy[2] - xy[0]) / (2.0 * step[:, None])
    inner = plain & (scene.curves.locate(found.curve, found.location - step)[0] == segment)
    inner &= scene.curves.locate(found.curve, found.location + step)[0] == segment
    np.testing.assert_allclose(
        (found.speed[:, None] * found.tangent)[inner], rate[inner], rtol=1e-5, atol=1e-5 * np.abs(rate).max()
    )
    across = np.abs(np.sum(found.offset * found.tangent, axis=1))
    assert (across[plain] < 1e-8).all()
    assert found.at_end.any() and found.at_corner.any()
    bound = np.stack([scene.curves.first[found.curve], scene.curves.last[found.curve]])
    ends = np.abs(found.location - bound).min(axis=0) < 1e-9
    assert ends[found.at_end].all() and not scene.curves.closed[found.curve[found.at_end]].any()


def test_a_foot_at_a_joint_of_a_smooth_curve_is_no_corner() -> None:
    """Beside knots of a straight spline all numbers are exact: the root is at the ends of both segments, in neither."""
    knots = [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [16.0, 0.0, 0.0], [24.0, 0.0, 0.0]]
    xy = np.array([[8.0, 3.0], [16.0, -2.0], [8.0, 0.0], [-4.0, 3.0]])
    image, above = np.zeros(4, dtype=np.int64), np.array([[0.0, 0.0, DISTANCE]])
    scene = scene_of([curve("natural_cubic", knots)], image, xy, np.eye(3)[None], above)
    found = find_candidates(scene, np.full(4, 6.0))
    assert found.point.tolist() == [0, 1, 2, 3]
    assert not found.at_corner.any()
    assert found.at_end.tolist() == [False, False, False, True]


def test_derivatives_of_places_in_the_photo() -> None:
    """Rates and second derivatives with which feet are moved onto curves that are no cubics."""
    scene, radius = scene_with_points(5, 200, 0.5)
    found = find_candidates(scene, radius)
    rows = np.arange(len(found))
    feet = PieceFeet(
        found.point, found.segment, np.full(len(rows), 0.4),
        rows, rows > 0, np.zeros((2, len(rows))), np.zeros((2, len(rows))), np.zeros(len(rows)),
    )  # fmt: skip
    h = 1e-5
    before, at, after = (_seen(scene, feet, feet.t + k * h) for k in (-1.0, 0.0, 1.0))
    for order in (0, 1):
        slope = (after[order] - before[order]) / (2.0 * h)
        near = np.abs(at[0]).max(axis=0) < 200.0
        np.testing.assert_allclose(at[order + 1][:, near], slope[:, near], rtol=1e-4, atol=1e-4)


def _projected(scene: Scene, found: Candidates, u: FloatArray) -> FloatArray:
    (xyz,) = scene.curves.evaluate(scene.coefficients, found.curve, u)
    image = scene.image[found.point]
    return project(scene.principal_distance[image], scene.rotation[image], scene.position[image], xyz)


def test_only_chosen_points_oriented_images_and_known_curves_are_looked_at() -> None:
    scene, radius = scene_with_points(1, 120, 0.5)
    everything = find_candidates(scene, radius)
    rotation, polynomials = scene.rotation.copy(), scene.polynomials.copy()
    rotation[1] = np.nan
    polynomials[slice(*scene.curves.segment_start[1:3])] = np.nan
    xy = scene.xy.copy()
    xy[4] = np.nan
    chosen = np.arange(0, 120, 2)[::-1]
    some = find_candidates(replace(scene, rotation=rotation, polynomials=polynomials, xy=xy), radius, chosen)
    kept = (everything.point % 2 == 0) & (scene.image[everything.point] != 1) & (everything.curve != 1)
    kept &= everything.point != 4
    assert kept.any() and not kept.all()
    np.testing.assert_array_equal(some.point, everything.point[kept])
    np.testing.assert_allclose(some.location, everything.location[kept], rtol=1e-12)


def test_nothing_is_found_where_there_is_nothing() -> None:
    scene, radius = scene_with_points(1, 12, 0.5)
    assert len(find_candidates(scene, radius, np.zeros(0, dtype=np.int64))) == 0
    far = find_candidates(replace(scene, xy=scene.xy + 1e4), radius)
    assert len(far) == 0 and far.offset.shape == (0, 2)
    behind = find_candidates(replace(scene, position=scene.position + [0.0, 0.0, -1e3]), radius)
    assert len(behind) == 0
