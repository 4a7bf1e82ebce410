"""Depths that nothing is known of, narrowed to where chains of three images agree more often than by chance.

The whole range is gone through octave by octave, each with the images that see the same at that depth.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import median_filter

from splinebba_cli.core.matching.fragments.consensus import agreed_depths
from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.labelled_points import hypotheses_of
from splinebba_cli.core.matching.fragments.partners import partner_images
from splinebba_cli.core.matching.fragments.scene_depths import MARGIN, SceneDepths, spread
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import FloatArray, IntArray

OCTAVE = 2.0
TRIALS = 400  # chain points of an image that stand for all
BELT = 0.01  # of the depth, in which agreed depths are counted
AROUND = 151  # belts whose median is the usual count
CHANCE = 4.0  # sigma above the usual count, from which a belt holds more than chance
FEWEST = 8  # agreed depths in a belt that can be more than chance
APART = 5  # belts between groups
SMALL_GROUP = 0.1  # of the excess of the largest group
DENSE = 2.0  # crossings of a point with the chains of one image, from which depths are narrowed


def narrowed(
    views: Views, chains: TracedChains, frames: Frames, scene: SceneDepths, gate: float
) -> SceneDepths:
    """Depths of the scene, narrowed where they are not known."""
    unknown = [int(k) for k in np.unique(chains.image) if not scene.known[k] and np.isfinite(scene.middle[k])]
    agreed: dict[int, list[FloatArray]] = {k: [] for k in unknown}
    crossings = np.zeros(len(scene.known))
    for part in _octaves(scene) if unknown else []:
        partners = partner_images(views, chains, frames, part)
        for k in unknown:
            if len(partners[k]) < 2 or part.known[k]:
                continue
            points = spread(chains.points_of(k), TRIALS)
            count, depth = _agreeing(views, chains, points, partners[k], part.limits[k], gate)
            agreed[k].append(depth)
            crossings[k] += count / (len(points) * len(partners[k]))
    limits, middle = scene.limits.copy(), scene.middle.copy()
    for k in unknown:
        if not agreed[k]:
            continue
        low, most, high = crowded_depths(np.concatenate(agreed[k]), scene.limits[k])
        if np.isfinite(most):
            middle[k] = most
        if np.isfinite(most) and crossings[k] > DENSE:
            margin = max(high - low, MARGIN * high)
            limits[k] = max(low - margin, limits[k, 0]), min(high + margin, limits[k, 1])
    return SceneDepths(limits, middle, scene.known)


def _octaves(scene: SceneDepths) -> list[SceneDepths]:
    """Parts of the depths of all images; an image whose depths are at an end stays there and counts as known."""
    low, high = scene.limits[:, 0], scene.limits[:, 1]
    with np.errstate(invalid="ignore"):
        number = np.where(np.isfinite(low), np.ceil(np.log(high / low) / np.log(OCTAVE)), 0.0)
    number = np.maximum(number, 1.0)
    out = []
    for k in range(int(number.max())):
        step = np.minimum(k, number - 1.0)
        begin = low * OCTAVE**step
        limits = np.column_stack([begin, np.minimum(begin * OCTAVE, high)])
        done = scene.known | (k >= number)
        limits[scene.known] = scene.limits[scene.known]
        out.append(SceneDepths(limits, np.sqrt(limits[:, 0] * limits[:, 1]), done))
    return out


def _agreeing(
    views: Views, chains: TracedChains, points: IntArray, partners: IntArray, limits: FloatArray, gate: float
) -> tuple[int, FloatArray]:
    """Number of crossings of points, and the depths on which two partners agree."""
    found = hypotheses_of(views, chains, points, partners, limits)
    if not len(found):
        return 0, np.zeros(0)
    agreed = agreed_depths(found, partners, limits, gate)
    return len(found), agreed.depth[(agreed.member >= 0).sum(axis=1) >= 2]


def crowded_depths(depth: FloatArray, limits: FloatArray) -> tuple[float, float, float]:
    """Depths between which agreement is no chance, least, most frequent and largest; NaN: nowhere.

    Chance agreement spreads evenly over inverse depth, of images that change slowly with depth.  A belt counts together
    with its neighbours on either side; small groups of belts far from the others are chance all the same.
    """
    belts = max(int(np.log(limits[1] / limits[0]) / BELT), 1)
    edges = np.geomspace(limits[0], limits[1], belts + 1)
    count = np.convolve(np.histogram(depth, edges)[0], np.ones(3), mode="same")
    usual = median_filter(count * edges[1:], AROUND, mode="nearest") / edges[1:]
    full = np.flatnonzero(count >= np.maximum(usual + CHANCE * np.sqrt(usual), FEWEST))
    if not len(full):
        return np.nan, np.nan, np.nan
    group = np.cumsum(np.diff(full, prepend=full[0]) > APART)
    excess = np.bincount(group, (count - usual)[full])
    full = full[excess[group] >= SMALL_GROUP * excess.max()]
    most = int(full[np.argmax(count[full])])
    return float(edges[full[0]]), float(edges[most]), float(edges[full[-1] + 1])
