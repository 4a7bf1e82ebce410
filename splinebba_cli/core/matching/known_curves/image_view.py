"""One image with its unlabelled points before the samples of the curves: what an alignment works on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.matching.known_curves.curve_samples import CurveSamples, SeenSamples, seen_from
from splinebba_cli.core.network import FloatArray, IntArray

BROADER = 16  # nearest samples among which one with the right direction is looked for


@dataclass(frozen=True)
class Pose:
    """An exterior orientation."""

    rotation: FloatArray  # (3, 3)
    position: FloatArray  # (3,)

    def moved(self, step: FloatArray) -> Pose:
        """After a step of theta (rad) and X0 (m), (6,)."""
        return Pose(self.rotation @ rotation_from_vector(step[None, :3])[0], self.position + step[3:])


@dataclass(frozen=True)
class ImageView:
    """Points of one image, and what may be seen on them."""

    principal_distance: float  # mm
    start: Pose  # mean of the prior
    xy: FloatArray  # (n, 2) mm, corrected
    sigma: FloatArray  # (n,) mm
    angle: FloatArray  # (n,) rad up to half a turn, NaN unknown
    angle_sigma: FloatArray  # (n,)
    samples: CurveSamples
    shape_sigma: FloatArray  # (N,) metres, of the samples in every direction
    direction_tolerance: float  # rad
    wrong_share: float  # of the points, at most, that belong to no curve

    def seen(self, pose: Pose) -> SeenSamples:
        """The samples from a pose."""
        return seen_from(self.samples, self.principal_distance, pose.rotation, pose.position)


@dataclass(frozen=True)
class Nearest:
    """The nearest sample with the right direction of some points."""

    point: IntArray  # (k,)
    sample: IntArray  # (k,)
    across: FloatArray  # (k,) mm, curve minus point along the normal
    along: FloatArray  # (k,) mm
    normal: FloatArray  # (k, 2)


def nearest_samples(view: ImageView, seen: SeenSamples, radius: float) -> Nearest:
    """For every point the nearest sample inside a radius whose direction agrees.

    Parameters
    ----------
    radius : mm
    """
    visible = np.flatnonzero(np.isfinite(seen.xy).all(axis=1))
    none = np.zeros(0, dtype=np.int64)
    if not len(visible) or not len(view.xy):
        return Nearest(none, none, np.zeros(0), np.zeros(0), np.zeros((0, 2)))
    tree = cKDTree(seen.xy[visible])
    count = min(BROADER, len(visible)) if np.isfinite(view.angle).any() else 1
    distance, found = tree.query(view.xy, k=[*range(1, count + 1)], distance_upper_bound=radius)
    inside = np.isfinite(distance)
    sample = visible[np.where(inside, found, 0)]
    tolerance = view.direction_tolerance + 3.0 * np.minimum(view.angle_sigma, 1.0)
    sine = np.abs(
        np.cos(view.angle)[:, None] * seen.direction[sample, 1]
        - np.sin(view.angle)[:, None] * seen.direction[sample, 0]
    )
    agrees = np.isnan(view.angle)[:, None] | (sine <= np.sin(np.minimum(tolerance, 0.5 * np.pi))[:, None])
    fits = inside & agrees
    point = np.flatnonzero(fits.any(axis=1))
    chosen = sample[point, np.argmax(fits[point], axis=1)]
    offset = seen.xy[chosen] - view.xy[point]
    tangent = seen.direction[chosen]
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    return Nearest(point, chosen, np.sum(normal * offset, axis=1), np.sum(tangent * offset, axis=1), normal)
