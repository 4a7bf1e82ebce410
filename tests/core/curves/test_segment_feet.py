"""Foot points on segments: lines against closed forms, ends, what is behind, Lee's rotation, error ellipses."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.foot_polynomials import foot_on_line_in_photo, foot_on_line_in_space
from splinebba_cli.core.curves.segment_feet import feet_in_photo, feet_of_rays


def test_on_straight_segments_they_are_those_in_closed_form() -> None:
    """Also where t runs unevenly: a cubic of one direction."""
    g = np.random.default_rng(1)
    seen = np.zeros((50, 4, 3))
    seen[:, 0], seen[:, 1] = (
        g.normal(0.0, [50.0, 50.0, 1.0], (50, 3)) + [0, 0, 9],
        g.normal(0.0, 30.0, (50, 3)),
    )
    seen[:, 1, 2] *= 0.05
    xy = seen[:, 0, :2] / seen[:, 0, 2:] + g.normal(0.0, 5.0, (50, 2))
    start, depth = seen[:, 0, :2].T - xy.T * seen[:, 0, 2], seen[:, :2, 2].T
    exact = np.clip(foot_on_line_in_photo(start, seen[:, 1, :2].T - xy.T * depth[1], depth), 0.0, 1.0)
    t, _ = feet_in_photo(seen, xy).nearest(50)
    assert ((exact > 0.0) & (exact < 1.0)).sum() > 5
    np.testing.assert_allclose(t, exact, atol=1e-12)
    uneven = seen.copy()
    uneven[:, 1], uneven[:, 2], uneven[:, 3] = 0.2 * seen[:, 1], 0.5 * seen[:, 1], 0.3 * seen[:, 1]
    s, _ = feet_in_photo(uneven, xy).nearest(50)
    np.testing.assert_allclose(0.2 * s + 0.5 * s**2 + 0.3 * s**3, exact, atol=1e-12)
    position, direction = g.normal(0.0, 1.0, (50, 3)), g.normal(0.0, 1.0, (50, 3)) + [0.0, 0.0, 5.0]
    unit = direction / np.linalg.norm(direction, axis=1)[:, None]
    first, second = (
        v - np.sum(v * unit, axis=1)[:, None] * unit for v in (seen[:, 0] - position, seen[:, 1])
    )
    exact = foot_on_line_in_space(first.T, second.T)
    ahead = np.sum((seen[:, 0] + exact[:, None] * seen[:, 1] - position) * unit, axis=1) > 0.0
    inside = ahead & (exact > 0.0) & (exact < 1.0)
    assert inside.sum() > 5
    t, distance = feet_of_rays(seen, position, direction).nearest(50)
    np.testing.assert_allclose(t[inside], exact[inside], atol=1e-12)
    np.testing.assert_allclose(
        distance[inside], np.linalg.norm(first + exact[:, None] * second, axis=1)[inside], atol=1e-9
    )


def test_the_ray_of_an_image_of_a_curve_meets_the_curve() -> None:
    """Direction R (x, y, -c)'; Lee (2008) 4.9 has R' instead, whose rays miss a curve 500 m away by far."""
    g = np.random.default_rng(2)
    rotation = rotation_object_from_photo(np.array([0.1, -0.2, 0.8]))
    position = np.array([10.0, -20.0, 500.0])
    a = g.normal(0.0, 20.0, (30, 4, 3))
    t = g.uniform(0.05, 0.95, 30)
    xyz = np.einsum("nk,nkc->nc", t[:, None] ** np.arange(4), a)
    xy = project(np.full(30, 150.0), rotation[None], position, xyz)
    ray = np.column_stack([xy, np.full(30, -150.0)])
    at = np.broadcast_to(position, (30, 3))
    found, distance = feet_of_rays(a, at, ray @ rotation.T).nearest(30)
    np.testing.assert_allclose(distance, 0.0, atol=1e-9)
    np.testing.assert_allclose(found, t, atol=1e-6)
    assert np.median(feet_of_rays(a, at, ray @ rotation).nearest(30)[1]) > 100.0


def test_what_lies_behind() -> None:
    """In the photo it does not exist; in space it is as far from a ray as from its beginning."""
    a = np.zeros((1, 4, 3))
    a[0, 0], a[0, 1] = [1.0, 2.0, -1.0], [0.0, 0.0, -4.0]
    assert not len(feet_in_photo(a, np.zeros((1, 2))).row)
    feet = feet_of_rays(a, np.zeros((1, 3)), np.array([[0.0, 0.0, 2.0]]))
    assert feet.t.tolist() == [0.0] and feet.at_end.all()
    np.testing.assert_allclose(feet.distance, np.sqrt(6.0))
    a[0, 1, 2] = 4.0  # passes the perspective centre's plane at 1/4: from there on it is sqrt(5) from the ray
    _, distance = feet_of_rays(a, np.zeros((1, 3)), np.array([[0.0, 0.0, 2.0]])).nearest(1)
    np.testing.assert_allclose(distance, np.sqrt(5.0))


def test_error_ellipses_decide_which_place_is_nearest() -> None:
    """A parabola around a point on its axis: the vertex is nearest in millimetres, the arms in sigma of 1 : 10."""
    seen = np.zeros((1, 4, 3))
    seen[0, 0], seen[0, 1], seen[0, 2] = [-1.0, 1.0, 1.0], [2.0, -4.0, 0.0], [0.0, 4.0, 0.0]  # y = x^2
    at = np.array([[0.0, 0.4]])
    plain = feet_in_photo(seen, at)
    assert abs(plain.t[0] - 0.5) < 1e-12 and abs(plain.distance[0] - 0.4) < 1e-12
    tight = feet_in_photo(seen, at, np.array([[[0.1, 0.0], [0.0, 1.0]]]))
    x = np.sqrt(0.4 - 0.5 * 0.01)  # of the least of (x / 10)^2 + (x^2 - 0.4)^2
    np.testing.assert_allclose(np.abs(2.0 * tight.t[:2] - 1.0), x, rtol=1e-9)
    assert not tight.at_end[:2].any()


def test_a_segment_that_is_a_point_has_a_distance() -> None:
    seen = np.zeros((1, 4, 3))
    seen[0, 0] = [3.0, 4.0, 1.0]
    _, distance = feet_in_photo(seen, np.zeros((1, 2))).nearest(1)
    assert distance.tolist() == [5.0]
