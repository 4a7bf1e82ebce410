"""Exterior orientation of one image from three or more object points.

All solutions of all (or a seeded choice of) triplets are judged by the sum of the smaller half of the squared
reprojection errors (least trimmed squares): it survives wrong points, but overfits where points are few.  So
its minimum only tells the noise, and the best solutions are refined by Gauss-Newton steps on all points below
three times that, and compared by the sum of squares cut off there (Torr and Zisserman 2000).  Three points
are always coplanar, so a flat set of ground control is no special case.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from math import comb

import numpy as np

from splinebba_cli.core.approximation.three_points import (
    finite_rows,
    orient_from_three_points,
    spread_ratio,
    triplet_areas,
)
from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

MAX_TRIPLETS = 300
MAX_REFINED = 8
COLLINEAR = 1e-4  # width over length of a set of points that counts as a line
EQUAL_FIT = 1.1  # ratio of two rms values that are not told apart
SAME_ROTATION_RAD = 1e-3
SAME_POSITION = 1e-3  # relative to the distance of the points
SCALE_FLOOR = 1e-7  # of the principal distance; inliers of noise-free data


class ResectionError(ValueError):
    """No exterior orientation can be derived.

    Attributes
    ----------
    reason : "too few points", "collinear points" or "no solution"
    """

    def __init__(self, reason: str, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason


@dataclass(frozen=True)
class Resection:
    """An exterior orientation, and how well it fits."""

    rotation: FloatArray  # (3, 3) object from photo
    position: FloatArray  # (3,) metres
    rms_mm: float  # root mean square of the residuals of x and y over the inliers
    n_inliers: int
    ambiguous: bool  # a different orientation fits as well


def resect(
    principal_distance_mm: float,
    corrected_xy: FloatArray,
    object_xyz: FloatArray,
    rough: tuple[FloatArray, FloatArray] | None = None,
    seed: int = 0,
) -> Resection:
    """Exterior orientation of an image from object points.

    Parameters
    ----------
    principal_distance_mm : float
    corrected_xy : (n, 2) float, millimetres, relative to the principal point, free of distortion
    object_xyz : (n, 3) float, metres
        Rows with NaN are ignored.
    rough : (rotation (3, 3), position (3,)), optional
        One more candidate; it also decides between orientations that fit equally.
    seed : int
        Of the choice of triplets where there are more than :data:`MAX_TRIPLETS`.

    Returns
    -------
    Resection

    Raises
    ------
    ResectionError
        Fewer than three points, points on one line, or no orientation with all points before the camera.
    """
    use = finite_rows(corrected_xy, object_xyz)
    photo, points = corrected_xy[use], object_xyz[use]
    _require_triangle(photo, points)
    centre = points.mean(axis=0)
    points = points - centre
    rays = np.column_stack([photo, np.full(len(photo), -principal_distance_mm)])
    triplets = sample_triplets(photo, points, seed)
    found = orient_from_three_points(rays[triplets], points[triplets])
    rotation, position = found.rotation, found.position
    if rough is not None:
        rotation = np.concatenate([rotation, rough[0][None]])
        position = np.concatenate([position, (rough[1] - centre)[None]])
    if not len(rotation):
        raise ResectionError("no solution", "no triplet of points has a real orientation")
    near = None if rough is None else (rough[0], rough[1] - centre)
    best = _best_solution(principal_distance_mm, photo, points, rotation, position, near)
    return replace(best, position=best.position + centre)


def _best_solution(
    distance: float,
    photo: FloatArray,
    points: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    rough: tuple[FloatArray, FloatArray] | None,
) -> Resection:
    """The best refinement of candidates (s, 3, 3), (s, 3)."""
    cost = _trimmed_costs(distance, rotation, position, photo, points)
    limit = error_limit(float(cost.min()), len(points), distance)
    solutions: list[Resection] = []
    for index in distinct_candidates(rotation, position, cost, points):
        refined = refine_on_inliers(distance, photo, points, rotation[index], position[index], limit)
        if refined is not None and not any(same_orientation(refined, other, points) for other in solutions):
            solutions.append(refined)
    if not solutions:
        raise ResectionError("no solution", "no orientation has all points before the camera")
    rotation = np.array([solution.rotation for solution in solutions])
    position = np.array([solution.position for solution in solutions])
    square = squared_residuals(distance, rotation, position, photo, points)
    fit = np.sqrt(np.minimum(square, limit**2).mean(axis=1))
    return choose_solution(solutions, fit, rough, distance)


def _require_triangle(photo: FloatArray, points: FloatArray) -> None:
    if len(points) < 3:
        raise ResectionError("too few points", f"{len(points)} of at least 3")
    if spread_ratio(points) < COLLINEAR:
        raise ResectionError("collinear points", "the object points lie on one line")
    if spread_ratio(photo) < COLLINEAR:
        raise ResectionError("collinear points", "the image points lie on one line")


def sample_triplets(photo: FloatArray, points: FloatArray, seed: int) -> IntArray:
    """All triplets, or the larger half of a random choice, (k, 3); none that is flat."""
    count = len(points)
    if comb(count, 3) <= MAX_TRIPLETS:
        triplets = np.array(list(combinations(range(count), 3)), dtype=np.int64)
    else:
        generator = np.random.default_rng(seed)
        triplets = np.argsort(generator.random((2 * MAX_TRIPLETS, count)), axis=1)[:, :3].astype(np.int64)
        triplets = triplets[np.argsort(-triplet_areas(photo[triplets]), kind="stable")[:MAX_TRIPLETS]]
    photo_area, object_area = triplet_areas(photo[triplets]), triplet_areas(points[triplets])
    flat = (photo_area < COLLINEAR * photo_area.max()) | (object_area < COLLINEAR * object_area.max())
    return np.asarray(triplets[~flat])


def squared_residuals(
    distance: float, rotation: FloatArray, position: FloatArray, photo: FloatArray, points: FloatArray
) -> FloatArray:
    """Squared reprojection errors under many orientations, (s, n) mm^2; inf behind the camera."""
    p = np.einsum("sji,snj->sni", rotation, points[None] - position[:, None])
    w = np.where(p[:, :, 2] < 0.0, p[:, :, 2], np.nan)
    error = -distance * p[:, :, :2] / w[:, :, None] - photo[None]
    square = np.sum(error * error, axis=2)
    return np.where(np.isfinite(square), square, np.inf)


def _trimmed_costs(
    distance: float, rotation: FloatArray, position: FloatArray, photo: FloatArray, points: FloatArray
) -> FloatArray:
    """Sum of the smaller half of the squared errors (all of them for three or four points), (s,)."""
    square = np.sort(squared_residuals(distance, rotation, position, photo, points), axis=1)
    return np.asarray(square[:, : smaller_half(len(points))].sum(axis=1))


def smaller_half(count: int) -> int:
    """How many of the smallest squares of `count` points judge a candidate."""
    return min(count, count // 2 + 2)


def distinct_candidates(
    rotation: FloatArray, position: FloatArray, cost: FloatArray, points: FloatArray
) -> list[int]:
    """The best candidates, leaving out those next to a better one."""
    reach = float(np.linalg.norm(points, axis=1).max())
    chosen: list[int] = []
    for index in np.argsort(cost, kind="stable"):
        if not np.isfinite(cost[index]) or len(chosen) == MAX_REFINED:
            break
        near = [
            np.linalg.norm(position[index] - position[k]) < 0.1 * reach
            and np.linalg.norm(rotation[index] - rotation[k]) < 0.1
            for k in chosen
        ]
        if len(points) == 3 or not any(near):
            chosen.append(int(index))
    return chosen


def error_limit(cost: float, count: int, distance: float) -> float:
    """Three standard deviations (mm) by the trimmed sum of squares of the best candidate.

    The mean of the smaller half of squares of normal errors in the plane is 0.307 of all, hence 1.8 =
    0.307^-1/2; the redundancy and 1 + 5/(n - 3) make up for the choice of the best one among few points.
    """
    redundancy = max(2 * smaller_half(count) - 6, 1)
    small_sample = 1.0 + 5.0 / max(count - 3, 1)
    return 3.0 * max(1.8 * small_sample * float(np.sqrt(cost / redundancy)), SCALE_FLOOR * distance)


def refine_on_inliers(
    distance: float,
    photo: FloatArray,
    points: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    limit: float,
) -> Resection | None:
    """Gauss-Newton on the points that fit, chosen again a few times; None where it leads nowhere."""

    def inliers() -> BoolArray:
        square = squared_residuals(distance, rotation[None], position[None], photo, points)[0]
        return np.asarray(square <= max(limit**2, float(np.sort(square)[smaller_half(len(square)) - 1])))

    inlier = inliers()
    for _ in range(5):
        found = _gauss_newton(distance, photo[inlier], points[inlier], rotation, position)
        if found is None:
            return None
        rotation, position = found
        again = inliers()
        if np.array_equal(again, inlier):
            break
        inlier = again
    square = squared_residuals(distance, rotation[None], position[None], photo[inlier], points[inlier])
    rms = float(np.sqrt(square.mean() / 2.0))
    return Resection(rotation, position, rms, int(inlier.sum()), False) if np.isfinite(rms) else None


def _gauss_newton(
    distance: float, photo: FloatArray, points: FloatArray, rotation: FloatArray, position: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Least squares on all given points, with damping that keeps every step downhill."""
    count = len(points)
    c = np.full(count, distance)
    reach = float(np.linalg.norm(points - position, axis=1).mean())
    scale = np.array([1.0, 1.0, 1.0, reach, reach, reach])

    def evaluate(r: FloatArray, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        xy, jacobian = project_with_jacobian(c, np.broadcast_to(r, (count, 3, 3)), x, points)
        error = (photo - xy).ravel()
        cost = float(error @ error)
        return cost if np.isfinite(cost) else np.inf, error, jacobian.orientation.reshape(-1, 6) * scale

    cost, error, design = evaluate(rotation, position)
    if not np.isfinite(cost):
        return None
    damping = 0.0
    for _ in range(60):
        normal = design.T @ design
        diagonal = damping * np.diag(np.diag(normal))
        step = np.asarray(
            np.linalg.lstsq(normal + diagonal, design.T @ error, rcond=1e-15)[0], dtype=np.float64
        )
        moved = rotation @ rotation_from_vector(step[:3]), position + reach * step[3:]
        new_cost, new_error, new_design = evaluate(*moved)
        if new_cost <= cost:
            (rotation, position), cost, error, design = moved, new_cost, new_error, new_design
            damping = 0.0 if damping < 1e-6 else damping / 10.0
        else:
            damping = max(10.0 * damping, 1e-6)
        if np.abs(step).max() < 1e-12 or damping > 1e6:
            break
    return rotation, position


def same_orientation(a: Resection, b: Resection, points: FloatArray) -> bool:
    """Whether two refinements ended in the same place."""
    reach = float(np.linalg.norm(points - a.position, axis=1).mean())
    return bool(
        np.linalg.norm(a.rotation - b.rotation) < SAME_ROTATION_RAD
        and np.linalg.norm(a.position - b.position) < SAME_POSITION * reach
    )


def choose_solution(
    solutions: list[Resection],
    fit: FloatArray,
    rough: tuple[FloatArray, FloatArray] | None,
    distance: float,
) -> Resection:
    """The solution with the smallest `fit` (s,) in mm; among equals the one nearest to `rough`."""
    limit = EQUAL_FIT * float(fit.min()) + 1e-9 * distance
    equal = [solutions[i] for i in np.argsort(fit, kind="stable") if fit[i] <= limit]
    best: Resection = equal[0]
    if rough is not None:
        reach = max(float(np.linalg.norm(best.position)), 1e-30)
        away = [
            np.linalg.norm(s.rotation - rough[0]) + np.linalg.norm(s.position - rough[1]) / reach
            for s in equal
        ]
        best = equal[int(np.argmin(away))]
    return replace(best, ambiguous=len(equal) > 1)
