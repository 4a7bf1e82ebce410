"""Which curves pass near a measured point, and where: every nearest place inside a radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.camera.collinearity import project, project_with_jacobian
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

SAMPLES_PER_SEGMENT, SAMPLES_PER_CURVE, FEWEST_SAMPLES = 24, 200, 2
NEIGHBOURS = 600  # samples that are looked at
NEWTON_STEPS = 4


@dataclass(frozen=True)
class Candidates:
    """Pairs of a point and a place on a curve near it, sorted by point, nearest first."""

    point: IntArray  # (k,)
    curve: IntArray  # (k,)
    location: FloatArray  # (k,) u of the foot point
    offset: FloatArray  # (k, 2) projected curve minus measured point, mm in the corrected photo
    tangent: FloatArray  # (k, 2) unit direction of the projected curve, in the sense of ascending u
    at_end: BoolArray  # (k,) clamped to an end of an open curve: the offset need not be across it

    def __len__(self) -> int:
        return len(self.point)


def find_candidates(scene: Scene, radius: FloatArray, points: IntArray | None = None) -> Candidates:
    """Foot points in the image on all curves that pass within a radius of measured points.

    Parameters
    ----------
    radius : (n,) mm, of every point of the scene
    points : (k,) points that are looked at, default all

    Returns
    -------
    Candidates
        One for every curve and every branch of it that has a local minimum of the distance inside the radius.
    """
    points = np.arange(len(scene.image)) if points is None else points
    curve, u = _samples(scene)
    (xyz,) = scene.curves.evaluate(scene.coefficients, curve, u, (0,))
    found_point, found_sample = [], []
    for k in np.unique(scene.image[points]):
        own = points[scene.image[points] == k]
        xy = project(
            scene.principal_distance[k : k + 1], scene.rotation[k : k + 1], scene.position[k : k + 1], xyz
        )
        seen = np.flatnonzero(np.isfinite(xy).all(axis=1))
        if not len(seen):
            continue
        step = np.linalg.norm(np.diff(xy[seen], axis=0), axis=1)[np.diff(curve[seen]) == 0]
        reach = float(radius[own].max()) + (float(np.quantile(step, 0.99)) if len(step) else 0.0)
        distance, near = cKDTree(xy[seen]).query(
            scene.xy[own], k=min(NEIGHBOURS, len(seen)), distance_upper_bound=reach
        )
        distance = np.asarray(distance).reshape(len(own), -1)
        near = np.asarray(near).reshape(len(own), -1)
        row, column = np.nonzero(np.isfinite(distance))
        sample = seen[near[row, column]]
        key = row * len(scene.curves.bases) + curve[sample]
        _, first = np.unique(key, return_index=True)  # nearest sample of every curve
        found_point.append(own[row[first]])
        found_sample.append(sample[first])
    if not found_point:
        return _refined(scene, radius, *(np.zeros(0, dtype=np.int64),) * 2, np.zeros(0))
    sample = np.concatenate(found_sample)
    return _refined(scene, radius, np.concatenate(found_point), curve[sample], u[sample])


def _refined(scene: Scene, radius: FloatArray, point: IntArray, curve: IntArray, u: FloatArray) -> Candidates:
    """Newton steps to the foot points, those outside of the radius left out."""
    curves, image = scene.curves, scene.image[point]
    camera = scene.principal_distance[image], scene.rotation[image], scene.position[image]
    low = np.where(curves.closed[curve], -np.inf, curves.first[curve])
    high = np.where(curves.closed[curve], np.inf, curves.last[curve])
    for last in [False] * NEWTON_STEPS + [True]:
        xyz, rate = curves.evaluate(scene.coefficients, curve, u, (0, 1))
        xy, jacobian = project_with_jacobian(*camera, xyz)
        offset = xy - scene.xy[point]
        along = np.einsum("kij,kj->ki", jacobian.object_xyz, rate)
        if not last:
            u = np.clip(u - np.sum(along * offset, axis=1) / np.sum(along**2, axis=1), low, high)
    distance = np.linalg.norm(offset, axis=1)
    keep = np.flatnonzero(distance <= radius[point])
    keep = keep[np.lexsort((distance[keep], point[keep]))]
    tangent = along / np.linalg.norm(along, axis=1, keepdims=True)
    at_end = (u <= low) | (u >= high)
    return Candidates(point[keep], curve[keep], u[keep], offset[keep], tangent[keep], at_end[keep])


def _samples(scene: Scene) -> tuple[IntArray, FloatArray]:
    """Samples of all curves, curve and u; fewer of a segment where a curve has many."""
    curves = scene.curves
    number = np.diff(curves.segment_start)[curves.owner]
    count = np.clip(SAMPLES_PER_CURVE // number, FEWEST_SAMPLES, SAMPLES_PER_SEGMENT)
    within = np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    segment = np.repeat(np.arange(len(count)), count)
    u = curves.left[segment] + curves.length[segment] * (within + 0.5) / count[segment]
    return curves.owner[segment], u
