"""Elimination of object points."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.elimination import PointPairs, eliminate_points
from splinebba_cli.core.observations.image_points import PointRows

POINT = np.array([0, 0, 1, 2, 2, 2])
IMAGE = np.array([1, 0, 2, 0, 1, 2])
MASK = np.array([[1.0, 1.0, 1.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0]])  # free, fixed, fixed in height


def rows(seed: int) -> PointRows:
    normal = np.random.default_rng(seed).normal
    return PointRows(
        residual=normal(size=(6, 2)),
        orientation=normal(size=(6, 2, 6)),
        object_xyz=normal(size=(6, 2, 3)),
        cost=0.0,
    )


def test_pairs_are_of_points_that_are_eliminated() -> None:
    pairs = PointPairs.of(POINT, IMAGE, MASK)
    found = {(POINT[a], IMAGE[a], IMAGE[b]) for a, b in zip(pairs.a, pairs.b, strict=True)}
    assert found == {
        *((0, i, j) for i, j in [(0, 0), (0, 1), (1, 1)]),
        *((2, i, j) for i, j in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]),
    }
    assert len(pairs.a) == len(found)


def test_elimination_against_the_full_matrix() -> None:
    """Step of the points for a given step of the images, from the equations of all unknowns together."""
    equations, weight, side = rows(3), np.full((3, 3), 0.1), np.full((3, 3), 0.7)
    free_images = np.ones((3, 6))
    free_images[1, :3] = 0.0
    found = eliminate_points(equations, IMAGE, POINT, free_images, MASK, weight, side, 0.0)
    step = np.random.default_rng(4).normal(size=(3, 6)) * free_images
    a = np.zeros((12, 9))
    for k, point in enumerate(POINT):
        a[2 * k : 2 * k + 2, 3 * point : 3 * point + 3] = equations.object_xyz[k]
    moved = np.einsum("kij,kj->ki", equations.orientation, step[IMAGE]) + equations.residual
    free = np.flatnonzero(MASK.ravel())
    normal = a[:, free].T @ a[:, free] + np.diag(weight.ravel()[free])
    expected = np.zeros(9)
    expected[free] = np.linalg.solve(normal, side.ravel()[free] - a[:, free].T @ moved.ravel())
    right = found.right_side.copy()
    np.subtract.at(right, POINT, np.einsum("kij,ki->kj", found.coupling, step[IMAGE]))
    points = np.einsum("nij,nj->ni", found.inverse, right) * MASK
    np.testing.assert_allclose(points.ravel(), expected, atol=1e-12)
