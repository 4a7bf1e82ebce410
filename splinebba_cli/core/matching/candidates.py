"""Which curves pass near a measured point, and where: every nearest place inside a radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray, IntArray

SAMPLES_PER_SEGMENT = 32


@dataclass(frozen=True)
class Candidates:
    """Pairs of a point and a place on a curve near it, sorted by point, nearest first."""

    point: IntArray  # (k,)
    curve: IntArray  # (k,)
    location: FloatArray  # (k,) u of the foot point
    offset: FloatArray  # (k, 2) projected curve minus measured point, mm in the corrected photo
    tangent: FloatArray  # (k, 2) unit direction of the projected curve, in the sense of ascending u

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
    found = []
    for k in np.unique(scene.image[points]):
        own = points[scene.image[points] == k]
        xy = project(
            scene.principal_distance[k : k + 1], scene.rotation[k : k + 1], scene.position[k : k + 1], xyz
        )
        seen = np.flatnonzero(np.isfinite(xy).all(axis=1))
        if not len(seen):
            continue
        for point, near in zip(
            own, cKDTree(xy[seen]).query_ball_point(scene.xy[own], radius[own]), strict=True
        ):
            rows = seen[near]
            distance = np.linalg.norm(xy[rows] - scene.xy[point], axis=1)
            order = np.argsort(distance)
            _, first = np.unique(curve[rows[order]], return_index=True)
            for row in rows[order[np.sort(first)]]:
                after = row + 1 if row + 1 < len(u) and curve[row + 1] == curve[row] else row - 1
                along = (xy[after] - xy[row]) * (1.0 if after > row else -1.0)
                found.append((point, curve[row], u[row], *(xy[row] - scene.xy[point]), *along))
    table = np.array(found).reshape(-1, 7)
    length = np.linalg.norm(table[:, 5:], axis=1, keepdims=True)
    return Candidates(
        table[:, 0].astype(np.int64), table[:, 1].astype(np.int64), table[:, 2], table[:, 3:5],
        table[:, 5:] / length,
    )  # fmt: skip


def _samples(scene: Scene) -> tuple[IntArray, FloatArray]:
    """Samples of all curves, curve and u."""
    curves = scene.curves
    owner = np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start))
    t = (np.arange(SAMPLES_PER_SEGMENT) + 0.5) / SAMPLES_PER_SEGMENT
    u = curves.left[:, None] + curves.length[:, None] * t
    return np.repeat(owner, SAMPLES_PER_SEGMENT), u.ravel()
