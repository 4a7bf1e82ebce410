"""Exterior orientation of one image from points of which some have tangents: P3P and P2PT in one robust loop.

Triplets of points and pairs of points with tangents give the candidates.  A candidate is judged by the smaller half of
the squares of all points, where the square of a point with a tangent is the mean of that of its place and that of its
direction times a lever (mm per radian: sigma of a place over sigma of a direction).  So two points with tangents
suffice, and a tangent tells the solutions of three points apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb

import numpy as np

from splinebba_cli.core.approximation.point_tangent import orient_from_point_tangents
from splinebba_cli.core.approximation.resection import (
    COLLINEAR,
    Resection,
    ResectionError,
    choose_solution,
    distinct_candidates,
    error_limit,
    refine_on_inliers,
    same_orientation,
    sample_triplets,
    smaller_half,
    squared_residuals,
)
from splinebba_cli.core.approximation.three_points import orient_from_three_points, spread_ratio
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

MAX_PAIRS = 300


@dataclass(frozen=True)
class PointsWithTangents:
    """Points of known place in one image; direction and tangent are NaN where unknown."""

    photo_xy: FloatArray  # (n, 2) mm, relative to the principal point, free of distortion
    object_xyz: FloatArray  # (n, 3) metres
    direction: FloatArray  # (n, 2) unit, in the photo, up to sense
    tangent: FloatArray  # (n, 3) unit
    lever: FloatArray  # (n,) mm per radian
    directed: BoolArray  # (n,) the direction has the sense of the tangent; else it is known up to half a turn

    @property
    def with_tangent(self) -> IntArray:
        """Points that have one."""
        finite = np.isfinite(self.direction).all(axis=1) & np.isfinite(self.tangent).all(axis=1)
        return np.flatnonzero(finite)


def resect_with_tangents(
    principal_distance_mm: float, points: PointsWithTangents, seed: int = 0
) -> Resection:
    """Exterior orientation of an image from points and tangents, also where many are wrong.

    Raises
    ------
    ResectionError
        Fewer than three points and fewer than two tangents, or no orientation with all points before the camera.
    """
    centre = points.object_xyz.mean(axis=0)
    xyz = points.object_xyz - centre
    rotation, position = _candidates(principal_distance_mm, points, xyz, seed)
    if not len(rotation):
        raise ResectionError("no solution", "neither three points nor two tangents have a real orientation")
    square = _squares(principal_distance_mm, points, xyz, rotation, position)
    half = smaller_half(len(xyz))
    cost = np.sort(square, axis=1)[:, :half].sum(axis=1)
    limit = error_limit(float(cost.min()), len(xyz), principal_distance_mm)
    solutions: list[Resection] = []
    for k in distinct_candidates(rotation, position, cost, xyz):
        refined = _refined(principal_distance_mm, points, xyz, rotation[k], position[k], limit)
        if refined is not None and not any(same_orientation(refined, other, xyz) for other in solutions):
            solutions.append(refined)
    if not solutions:
        raise ResectionError("no solution", "no orientation has all points before the camera")
    square = _squares(
        principal_distance_mm, points, xyz,
        np.array([each.rotation for each in solutions]), np.array([each.position for each in solutions]),
    )  # fmt: skip
    fit = np.sqrt(np.minimum(square, limit**2).mean(axis=1))
    chosen = choose_solution(solutions, fit, None, principal_distance_mm)
    return Resection(
        chosen.rotation, chosen.position + centre, chosen.rms_mm, chosen.n_inliers, chosen.ambiguous
    )


def _candidates(
    distance: float, points: PointsWithTangents, xyz: FloatArray, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Of triplets of points and of pairs of points with tangents, (s, 3, 3), (s, 3)."""
    rays = np.column_stack([points.photo_xy, np.full(len(xyz), -distance)])
    rotation, position = [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    if len(xyz) >= 3 and min(spread_ratio(xyz), spread_ratio(points.photo_xy)) > COLLINEAR:
        triplets = sample_triplets(points.photo_xy, xyz, seed)
        of_three = orient_from_three_points(rays[triplets], xyz[triplets])
        rotation.append(of_three.rotation)
        position.append(of_three.position)
    if len(points.with_tangent) >= 2:
        pairs = _pairs(points.with_tangent, seed)
        of_two = orient_from_point_tangents(
            rays[pairs], points.direction[pairs], xyz[pairs], points.tangent[pairs]
        )
        rotation.append(of_two.rotation)
        position.append(of_two.position)
    if len(rotation) == 1:
        raise ResectionError(
            "too few points", f"{len(xyz)} of at least 3, {len(points.with_tangent)} of at least 2 tangents"
        )
    return np.concatenate(rotation), np.concatenate(position)


def _pairs(rows: IntArray, seed: int) -> IntArray:
    """All pairs, or a random choice, (k, 2)."""
    if comb(len(rows), 2) <= MAX_PAIRS:
        return np.array(list(combinations(rows.tolist(), 2)), dtype=np.int64)
    order = np.argsort(np.random.default_rng(seed).random((MAX_PAIRS, len(rows))), axis=1)
    return np.asarray(rows[order[:, :2]])


def _squares(
    distance: float, points: PointsWithTangents, xyz: FloatArray, rotation: FloatArray, position: FloatArray
) -> FloatArray:
    """Squares of all points under orientations, (s, n) mm^2; infinite behind the camera."""
    square = squared_residuals(distance, rotation, position, points.photo_xy, xyz)
    rows = points.with_tangent
    p = np.einsum("sji,snj->sni", rotation, xyz[rows] - position[:, None])
    t = np.einsum("sji,nj->sni", rotation, points.tangent[rows])
    flow = p[:, :, :2] * t[:, :, 2:] - t[:, :, :2] * p[:, :, 2:]  # before the camera p_z < 0
    along = points.direction[rows]
    across = flow[:, :, 0] * along[:, 1] - flow[:, :, 1] * along[:, 0]
    against = points.directed[rows] & (np.sum(flow * along, axis=2) < 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        sine = np.where(against, 2.0, across / np.linalg.norm(flow, axis=2))
    turned = (points.lever[rows] * np.nan_to_num(sine, nan=1.0)) ** 2
    square[:, rows] = 0.5 * (square[:, rows] + turned)
    return square


def _refined(
    distance: float,
    points: PointsWithTangents,
    xyz: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    limit: float,
) -> Resection | None:
    """By the places of the points that fit where there are enough of them; else the candidate itself."""
    if len(xyz) >= 4:
        return refine_on_inliers(distance, points.photo_xy, xyz, rotation, position, limit)
    square = squared_residuals(distance, rotation[None], position[None], points.photo_xy, xyz)
    rms = float(np.sqrt(square.mean() / 2.0))
    return Resection(rotation, position, rms, len(xyz), False) if np.isfinite(rms) else None
