"""Forward intersection: object points from image points of oriented images, many points at once.

    start       sum_i (I - d_i d_i') (X - X0_i) = 0,    d = R (x, y, -c)' / |.|    (nearest point of the rays)
    refinement  Gauss-Newton on the collinearity equations, in the image

The angle under which the rays of a point meet is measured by the smallest eigenvalue m of the matrix of the
start: two rays at the angle a have m = 1 - cos a, so a = arccos(1 - m).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

PARALLEL_RAD = np.radians(0.1)  # below: no intersection
WEAK_RAD = np.radians(2.0)  # below: flagged as weak
MAX_ITERATIONS = 12


@dataclass(frozen=True)
class Intersections:
    """Intersected points."""

    xyz: FloatArray  # (n, 3) metres; NaN where there is no intersection
    weak: BoolArray  # (n,) intersected at an angle below 2 degrees
    rays: IntArray  # (n,) number of rays used
    angle: FloatArray  # (n,) rad, angle of intersection (two rays), NaN below two rays


def intersect_points(
    point: IntArray,
    count: int,
    principal_distance_mm: FloatArray,
    corrected_xy: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
) -> Intersections:
    """Object points from rays.

    Parameters
    ----------
    point : (k,) int
        Index of the point that each ray belongs to.
    count : int
        Number of points n.
    principal_distance_mm : (k,) float
    corrected_xy : (k, 2) float, millimetres, relative to the principal point, free of distortion
    rotation : (k, 3, 3) float, object from photo, of the image of each ray
    position : (k, 3) float, metres
        Rays with NaN in the orientation are ignored.

    Returns
    -------
    Intersections
        NaN with fewer than two rays, rays nearly parallel (below 0.1 degree) or a point behind a camera.
    """
    use = np.isfinite(position).all(axis=1) & np.isfinite(rotation).all(axis=(1, 2))
    use &= np.isfinite(corrected_xy).all(axis=1)
    point, c, photo = point[use], principal_distance_mm[use], corrected_xy[use]
    rotation, position = rotation[use], position[use]
    rays = np.bincount(point, minlength=count)
    if not len(point):
        nothing = np.full(count, np.nan)
        return Intersections(np.full((count, 3), np.nan), np.zeros(count, dtype=bool), rays, nothing)
    shift = position.mean(axis=0)
    xyz, angle = _nearest_point(point, count, np.column_stack([photo, -c]), rotation, position - shift)
    xyz[(rays < 2) | ~(angle >= PARALLEL_RAD)] = np.nan
    xyz = _refine(xyz, point, c, photo, rotation, position - shift)
    weak = np.isfinite(xyz).all(axis=1) & (angle < WEAK_RAD)
    return Intersections(xyz + shift, weak, rays, np.where(rays < 2, np.nan, angle))


def _sums(point: IntArray, count: int, rows: FloatArray) -> FloatArray:
    """Sum of rows (k, ...) by point, (n, ...)."""
    out = np.zeros((count, *rows.shape[1:]))
    np.add.at(out, point, rows)
    return out


def _nearest_point(
    point: IntArray, count: int, photo_ray: FloatArray, rotation: FloatArray, position: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Point nearest to the rays (n, 3) and the angle of intersection (n,)."""
    direction = np.einsum("kij,kj->ki", rotation, photo_ray)
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    across = np.eye(3) - direction[:, :, None] * direction[:, None, :]
    normal = _sums(point, count, across)
    right = _sums(point, count, np.einsum("kij,kj->ki", across, position))
    value, vector = np.linalg.eigh(normal)
    safe = np.where(value > 1e-12, value, np.inf)
    xyz = np.einsum("nij,nj->ni", vector, np.einsum("nji,nj->ni", vector, right) / safe)
    angle = np.arccos(np.clip(1.0 - value[:, 0], 0.0, 1.0))
    return xyz, angle


def _refine(
    xyz: FloatArray,
    point: IntArray,
    c: FloatArray,
    photo: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
) -> FloatArray:
    """Gauss-Newton in the image; NaN behind a camera; steps that do not improve are not taken."""
    count = len(xyz)

    def evaluate(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        xy, jacobian = project_with_jacobian(c, rotation, position, x[point])
        error = photo - xy
        a = jacobian.object_xyz
        cost = _sums(point, count, np.sum(error * error, axis=1))
        return (
            np.where(np.isfinite(cost), cost, np.inf),
            _sums(point, count, np.einsum("kri,krj->kij", a, a)),
            _sums(point, count, np.einsum("kri,kr->ki", a, error)),
        )

    cost, normal, right = evaluate(xyz)
    active = np.isfinite(cost) & np.isfinite(xyz).all(axis=1)
    xyz = np.where(active[:, None], xyz, np.nan)
    for _ in range(MAX_ITERATIONS):
        rows = np.flatnonzero(active)
        if not len(rows):
            break
        trace = np.trace(normal[rows], axis1=1, axis2=2)[:, None, None]
        step = np.linalg.solve(normal[rows] + 1e-14 * trace * np.eye(3), right[rows][:, :, None])[:, :, 0]
        trial = xyz.copy()
        trial[rows] += step
        new_cost, new_normal, new_right = evaluate(trial)
        better = active & (new_cost <= cost)
        xyz = np.where(better[:, None], trial, xyz)
        cost = np.where(better, new_cost, cost)
        normal = np.where(better[:, None, None], new_normal, normal)
        right = np.where(better[:, None], new_right, right)
        depth = np.zeros(count)
        depth[rows] = np.abs(step).max(axis=1) / (1.0 + np.abs(xyz[rows]).max(axis=1))
        active = better & (depth > 1e-13)
    return xyz
