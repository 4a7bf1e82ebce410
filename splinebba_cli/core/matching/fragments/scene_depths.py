"""Where objects can lie: plausible depths of every image.

From the object points that the image measured and the given curves in its frame, widened by their range.  Where these
are few: the depths at which rays stay in sight of another image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.state import initial_coefficients, prepare

KNOWN = 8  # object points in an image that tell its depths
MARGIN = 0.03  # of the depth, at least, on either side of known points
SAMPLES = 64  # chain points that stand for their image
LEAST_SIGHT = 0.05  # of the samples that another image must see at a depth


@dataclass(frozen=True)
class SceneDepths:
    """Least and largest depth in every image, in the unit of :class:`Views`; NaN: the image sees nothing in common."""

    limits: FloatArray  # (m, 2)
    middle: FloatArray  # (m,) where most objects lie
    known: BoolArray  # (m,) from object points, else from the frames


def plausible_depths(
    network: Network, object_xyz: FloatArray, views: Views, chains: TracedChains, frames: Frames
) -> SceneDepths:
    """Depths of all images with chains.

    Parameters
    ----------
    object_xyz : (n, 3) present coordinates of the network's points, NaN where unknown
    """
    limits = np.full((len(views.position), 2), np.nan)
    known = np.zeros(len(views.position), dtype=bool)
    places = _places_of_curves(network)
    seen = network.point_observations
    for k in np.unique(chains.image):
        own = places[frames.shows(views, np.full(len(places), k), places)]
        xyz = np.vstack([object_xyz[np.unique(seen.point[seen.image == k])], own])
        depth = -(xyz - views.position[k]) @ views.rotation[k][:, 2] / views.principal_distance[k]
        depth = depth[np.isfinite(depth) & (depth > 0.0)]
        known[k] = len(depth) >= KNOWN
        if known[k]:
            least, most = float(depth.min()), float(depth.max())
            margin = max(most - least, MARGIN * most)
            limits[k] = max(least - margin, 0.2 * least), most + margin
        else:
            limits[k] = _common_depths(views, chains, frames, int(k))
    return SceneDepths(limits, np.sqrt(limits[:, 0] * limits[:, 1]), known)


def _places_of_curves(network: Network) -> FloatArray:
    """Beginnings and middles of all segments of the curves, (k, 3) metres; NaN where the shape is not known."""
    prepared = prepare(network)
    curves = prepared.curves
    owner, u = np.tile(curves.owner, 2), np.concatenate([curves.left, curves.left + 0.5 * curves.length])
    own = curves.has_location[owner]
    return curves.evaluate(initial_coefficients(prepared), owner[own], u[own])[0]


def _common_depths(views: Views, chains: TracedChains, frames: Frames, image: int) -> FloatArray:
    """Depths at which rays of an image stay in sight of another one, (2,); NaN where there are none."""
    others = [int(j) for j in np.unique(chains.image) if j != image]
    base = np.linalg.norm(views.position[others] - views.position[image], axis=1)
    if not len(base) or base.max() <= 0.0:
        return np.full(2, np.nan)
    samples = spread(chains.points_of(image), SAMPLES)
    depth = (
        np.geomspace(0.3 * base[base > 0.0].min(), 30.0 * base.max(), 60) / views.principal_distance[image]
    )
    xyz = (views.position[image] + depth[:, None, None] * chains.ray[samples]).reshape(-1, 3)
    seen = np.zeros(len(xyz), dtype=bool)
    for j in others:
        seen |= frames.shows(views, np.full(len(xyz), j), xyz)
    common = depth[seen.reshape(len(depth), -1).mean(axis=1) > LEAST_SIGHT]
    return np.array([common[0], common[-1]]) if len(common) else np.full(2, np.nan)


def spread(points: IntArray, count: int) -> IntArray:
    """At most so many of the points, evenly."""
    return points[np.linspace(0, len(points) - 1, min(count, len(points))).astype(np.int64)]
