"""Scenes of curves of every kind before tilted images, and what dense sampling finds in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from splinebba_cli.core.camera.collinearity import photo_frame_xyz
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import Curve, FloatArray, IntArray

DISTANCE = 100.0
HEIGHT = 100.0


def curve(family: str, values: object, **options: object) -> Curve:
    rows = np.asarray(values, dtype=float)
    return Curve(family, "control", family, rows, np.zeros(rows.shape), **options)  # type: ignore[arg-type]


def many_curves(seed: int) -> list[Curve]:
    """Curves of every family within some 60 m of the origin: bends, loops, corners, straight ones, a point."""
    g = np.random.default_rng(seed)

    def around(count: int, size: float = 30.0) -> FloatArray:
        return np.column_stack([g.uniform(-size, size, (count, 2)), g.uniform(-3.0, 3.0, count)])

    walk = np.cumsum(g.normal(0.0, [8.0, 8.0, 0.5], (30, 3)), axis=0) * 0.5
    radius = np.array([[12.0, 5.0, 0.3], [-4.0, 10.0, 0.2]])
    return [
        curve("natural_cubic", around(7)),
        curve("natural_cubic", walk),
        curve("natural_cubic", around(6), closed=True),
        curve("natural_cubic", around(6), breaks=(2, 3)),
        curve("straight_line", around(2)),
        curve("natural_cubic", np.linspace(around(1)[0], around(1)[0], 4)),  # straight, as a spline
        curve("bspline_1", around(5)),  # corners at all knots
        curve("bspline_3", around(7)),
        curve("free_cubic", np.vstack([around(1), around(3, 90.0)])),  # loops
        curve("catmull_rom", around(5), closed=True),
        curve("conic", np.vstack([around(1), radius])),
        curve("circle", np.vstack([around(1), [[9.0, 0.0, 0.0], [0.0, 9.0, 0.0]]])),
        curve("conic", np.vstack([around(1), 1.5 * radius]), knot_parameters=np.array([0.4, 3.9])),
        curve(
            "fourier", np.vstack([around(1), 1.5 * radius, 0.4 * radius[::-1], g.normal(0.0, 1.0, (4, 3))])
        ),
        curve("polynomial_0", [[1.0, 2.0, 0.0]]),
    ]


def scene_of(
    curves: Sequence[Curve], image: IntArray, xy: FloatArray, rotation: FloatArray, position: FloatArray
) -> Scene:
    """Points xy (n, 2) of images before curves."""
    tables = CurveSet.of([basis_of(each) for each in curves])
    coefficients = np.vstack(
        [
            basis.coefficients_from_values(each.values)
            for basis, each in zip(tables.bases, curves, strict=True)
        ]
    )
    return Scene(
        curves=tables,
        coefficients=coefficients,
        polynomials=tables.segment_polynomials(coefficients),
        rotation=rotation,
        position=position,
        principal_distance=np.full(len(position), DISTANCE),
        image=image,
        xy=xy,
        whitening=np.tile(np.eye(2), (len(xy), 1, 1)),
        chain=np.full(len(xy), -1),
        direction=np.full(len(xy), np.nan),
    )


def tilted_images(seed: int) -> tuple[FloatArray, FloatArray]:
    """A vertical image, a tilted one, and one near the ground that looks across it: curves pass behind it."""
    g = np.random.default_rng(seed)
    position = np.array([[0.0, 0.0, HEIGHT], [40.0, -30.0, HEIGHT], [-5.0, 3.0, 4.0]])
    turns = np.array([[0.0, 0.0, 0.3], [0.3, 0.35, -1.0], [1.4, 0.2, 0.1]]) + g.normal(0.0, 0.02, (3, 3))
    return rotation_from_vector(turns), position


def minima_by_sampling(scene: Scene, k: int, number: int, samples: int) -> list[FloatArray]:
    """Distances of all local minima of a curve in front of image k, of each of its points.

    Samples tell where they are, each is then found between its neighbours by halving.
    """
    basis = scene.curves.bases[number]
    breaks = basis.break_points
    parts = np.linspace(0.0, 1.0, samples, endpoint=False)
    u = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * parts).ravel(), breaks[-1])
    seen = _photo_xy(scene, k, number, u)
    xy = scene.xy[scene.image == k]
    rows, places = [], []
    for row, point in enumerate(xy):
        distance = np.hypot(*(seen - point).T)
        before, after = np.append(np.inf, distance[:-1]), np.append(distance[1:], np.inf)
        if basis.closed:
            before[0], distance[-1] = distance[-2], np.inf
        places.append(np.flatnonzero((distance <= before) & (distance < after) & np.isfinite(distance)))
        rows.append(np.full(len(places[-1]), row))
    row, place = np.concatenate(rows), np.concatenate(places)
    step = np.diff(breaks).max() / samples
    low, high = u[place] - step, u[place] + step
    if not basis.closed:
        low, high = np.maximum(low, breaks[0]), np.minimum(high, breaks[-1])

    def distance_at(at: FloatArray) -> FloatArray:
        return np.hypot(*(_photo_xy(scene, k, number, at) - xy[row]).T)

    for _ in range(90):
        left, right = (2.0 * low + high) / 3.0, (low + 2.0 * high) / 3.0
        nearer = distance_at(left) <= distance_at(right)
        low, high = np.where(nearer, low, left), np.where(nearer, right, high)
    found = np.minimum(distance_at(0.5 * (low + high)), distance_at(u[place]))
    return [np.sort(found[row == each]) for each in range(len(xy))]


def _photo_xy(scene: Scene, k: int, number: int, u: FloatArray) -> FloatArray:
    """Places of a curve in image k, (n, 2); inf behind it."""
    rows = slice(*scene.curves.coefficient_start[number : number + 2].tolist())
    xyz = scene.curves.bases[number].evaluate(u, scene.coefficients[rows])
    p = photo_frame_xyz(scene.rotation[k][None], scene.position[k], xyz)
    with np.errstate(all="ignore"):
        return np.where(p[:, 2:] < 0.0, -DISTANCE * p[:, :2] / p[:, 2:], np.inf)
