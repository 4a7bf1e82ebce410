"""Where objects can lie: plausible depths of every image, and which images see the same of them."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray, Network

KNOWN = 8  # object points in an image that tell its depths
MARGIN = 0.03  # of the depth, at least, on either side of known points
PARTNERS = 8  # images that every image is compared with
SAMPLES = 64  # chain points that stand for their image
FRAME = 0.05  # margin of the format
SMALL_ANGLE_RAD = np.radians(6.0)  # below: partners are worth less
LARGE_ANGLE_RAD = np.radians(50.0)  # above: they see other sides of things
LEAST_OVERLAP = 0.05


def plausible_depths(network: Network, views: Views, chains: TracedChains) -> FloatArray:
    """Least and largest depth of objects in every image, (m, 2), in the unit of :class:`Views`.

    From the known object points and curves that the image sees, widened by their range; where these are few, from
    the depths at which a ray stays in sight of another image.
    """
    known = [network.points.xyz, *(curve.values for curve in network.curves if curve.family != "fourier")]
    xyz = np.vstack(known)
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    low, high = _frames(views, chains)
    out = np.full((len(views.position), 2), np.nan)
    for k in np.unique(chains.image):
        depth = _seen_depths(views, int(k), xyz, low, high)
        if len(depth) >= KNOWN:
            least, most = float(depth.min()), float(depth.max())
            margin = max(most - least, MARGIN * most)
            out[k] = max(least - margin, 0.2 * least), most + margin
        else:
            out[k] = _common_depths(views, chains, int(k), low, high)
    return out


def partner_images(views: Views, chains: TracedChains, depths: FloatArray) -> list[IntArray]:
    """Images that every image is compared with, best first: they see the same at a fair angle; (m,) arrays."""
    low, high = _frames(views, chains)
    out = [np.zeros(0, dtype=np.int64) for _ in views.position]
    images = np.unique(chains.image)
    for k in images:
        others = images[images != k]
        if not len(others) or not np.isfinite(depths[k]).all():
            continue
        ray = chains.ray[_samples(chains, int(k))]
        middle = views.position[k] + ray * np.sqrt(depths[k, 0] * depths[k, 1])
        points = np.vstack([middle, *(views.position[k] + ray * depth for depth in depths[k])])
        seen = np.array([_inside(views, int(j), points, low, high).mean() for j in others])
        centre = middle.mean(axis=0)
        angle = _angles(views.position[k] - centre, views.position[others] - centre)
        worth = seen * np.minimum(1.0, angle / SMALL_ANGLE_RAD) * np.minimum(1.0, LARGE_ANGLE_RAD / angle)
        worth[seen < LEAST_OVERLAP] = 0.0
        order = np.argsort(-worth, kind="stable")[:PARTNERS]
        out[k] = others[order[worth[order] > 0.0]]
    return out


def _samples(chains: TracedChains, image: int) -> IntArray:
    own = np.flatnonzero(chains.image == image)
    return own[np.linspace(0, len(own) - 1, min(SAMPLES, len(own))).astype(np.int64)]


def _frames(views: Views, chains: TracedChains) -> tuple[FloatArray, FloatArray]:
    """Corners of what every image shows: the box of its chains with a margin, (m, 2) each; empty without chains."""
    low = np.full((len(views.position), 2), np.inf)
    high = np.full((len(views.position), 2), -np.inf)
    np.minimum.at(low, chains.image, chains.xy)
    np.maximum.at(high, chains.image, chains.xy)
    margin = FRAME * np.where(high > low, high - low, 0.0).max(axis=1, keepdims=True)
    return low - margin, high + margin


def _inside(views: Views, image: int, xyz: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    xy = views.project(np.full(len(xyz), image), xyz)
    with np.errstate(invalid="ignore"):
        return np.asarray(((xy >= low[image]) & (xy <= high[image])).all(axis=1))


def _seen_depths(views: Views, image: int, xyz: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    seen = xyz[_inside(views, image, xyz, low, high)]
    depth = -(seen - views.position[image]) @ views.rotation[image][:, 2]
    return np.asarray(depth / views.principal_distance[image])


def _common_depths(
    views: Views, chains: TracedChains, image: int, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Depths at which rays of an image stay in sight of another one, (2,); NaN where there are none."""
    others = [int(j) for j in np.unique(chains.image) if j != image]
    base = np.linalg.norm(views.position[others] - views.position[image], axis=1)
    if not len(base) or base.max() <= 0.0:
        return np.full(2, np.nan)
    samples = _samples(chains, image)
    depth = np.geomspace(0.3 * base[base > 0.0].min(), 30.0 * base.max(), 60) / views.principal_distance[image]
    xyz = views.position[image] + depth[:, None, None] * chains.ray[samples]
    seen = np.zeros(len(depth) * len(samples), dtype=bool)
    for j in others:
        seen |= _inside(views, j, xyz.reshape(-1, 3), low, high)
    common = depth[seen.reshape(len(depth), -1).mean(axis=1) > LEAST_OVERLAP]
    return np.array([common[0], common[-1]]) if len(common) else np.full(2, np.nan)


def _angles(first: FloatArray, others: FloatArray) -> FloatArray:
    cosine = others @ first / (np.linalg.norm(others, axis=1) * np.linalg.norm(first))
    return np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)), 1e-9)
