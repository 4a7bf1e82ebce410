"""Images that are compared with each other: those that see the same at a fair angle."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.scene_depths import SceneDepths
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

PARTNERS = 8  # images that every image is compared with
NEAR = 48  # nearest images among which they are sought
SAMPLES = 64  # chain points that stand for their image
SMALL_ANGLE_RAD = np.radians(6.0)  # below: worth less
LARGE_ANGLE_RAD = np.radians(40.0)  # above: other sides of things
LEAST_OVERLAP = 0.05


def partner_images(views: Views, chains: TracedChains, frames: Frames, scene: SceneDepths) -> list[IntArray]:
    """Partners of every image, best first; one array an image."""
    out = [np.zeros(0, dtype=np.int64) for _ in views.position]
    images = np.unique(chains.image)
    images = images[np.isfinite(scene.limits[images]).all(axis=1)]
    if len(images) < 2:
        return out
    middle = {int(k): _middle(views, chains, scene, int(k)) for k in images}
    tree = cKDTree(np.array([each.mean(axis=0) for each in middle.values()]))
    for k, own in middle.items():
        _, near = tree.query(own.mean(axis=0), k=min(NEAR, len(images)))
        others = images[np.setdiff1d(near, np.flatnonzero(images == k))]
        out[k] = _best(views, frames, scene, k, own, others)
    return out


def _middle(views: Views, chains: TracedChains, scene: SceneDepths, image: int) -> FloatArray:
    """Object points on rays of an image at middle depth, (s, 3)."""
    own = chains.points_of(image)
    own = own[np.linspace(0, len(own) - 1, min(SAMPLES, len(own))).astype(np.int64)]
    return np.asarray(views.position[image] + chains.ray[own] * scene.middle[image])


def _best(
    views: Views, frames: Frames, scene: SceneDepths, image: int, middle: FloatArray, others: IntArray
) -> IntArray:
    here = views.position[image]
    ratio = scene.limits[image] / scene.middle[image]
    points = np.vstack([middle, *(here + (middle - here) * each for each in ratio)])
    seen = np.array([frames.shows(views, np.full(len(points), j), points).mean() for j in others])
    centre = middle.mean(axis=0)
    one, two = here - centre, views.position[others] - centre
    cosine = two @ one / (np.linalg.norm(two, axis=1) * np.linalg.norm(one))
    angle = np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)), 1e-9)
    worth = seen * np.minimum(1.0, angle / SMALL_ANGLE_RAD) * np.minimum(1.0, LARGE_ANGLE_RAD / angle) ** 2
    worth[seen < LEAST_OVERLAP] = 0.0
    order = np.argsort(-worth, kind="stable")[:PARTNERS]
    return np.asarray(others[order[worth[order] > 0.0]])
