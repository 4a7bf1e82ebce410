"""Corners: places where an edge turns sharply in the images that show it.

The turn at a point of a chain is the angle between the chords to the points REACH before and after it, and must show
over half of that, too: a bend is spread out, a corner is not.  A strand has a corner where two images or
more, and at least half of those that show the place, have one.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.shapes.overlaps import ImagePoints
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

REACH = 4
SHARP = np.radians(40.0)
FEWEST_IMAGES = 2
FEWEST = 4  # places in a part of a fragment


def corner_points(points: ImagePoints, chain: IntArray) -> BoolArray:
    """Whether a chain turns sharply at a point, (n,): the sharpest of its neighbourhood.

    Parameters
    ----------
    chain : (n,) -1: single points; those of a chain follow each other
    """
    wide, narrow = _turns(points.xy, chain, REACH), _turns(points.xy, chain, REACH // 2)
    turn = np.minimum(wide, narrow + 0.25 * SHARP)
    sharpest = np.ones(len(turn), dtype=bool)
    for shift in range(1, REACH + 1):
        sharpest[shift:] &= turn[shift:] > turn[:-shift]
        sharpest[:-shift] &= turn[:-shift] >= turn[shift:]
    return np.asarray(sharpest & (turn > SHARP))


def _turns(xy: FloatArray, chain: IntArray, reach: int) -> FloatArray:
    """Angle between the chords before and after every point, rad; 0 near the ends of chains."""
    count = len(xy)
    turn = np.zeros(count)
    if count <= 2 * reach:
        return turn
    middle = np.arange(reach, count - reach)
    inside = (chain[middle - reach] == chain[middle + reach]) & (chain[middle] >= 0)
    middle = middle[inside]
    before, after = xy[middle] - xy[middle - reach], xy[middle + reach] - xy[middle]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn[middle] = np.abs(np.arctan2(cross, np.sum(before * after, axis=1)))
    return turn


def cut_at_corners(fragment: Fragment, corner: BoolArray, image: IntArray) -> list[Fragment]:
    """The parts of a fragment between its corners.

    Parameters
    ----------
    corner : (n,) of all unlabelled points
    image : (n,)
    """
    if fragment.closed:
        return [fragment]
    at = np.flatnonzero(corner[fragment.link_row])
    cuts: list[float] = []
    order = at[np.argsort(fragment.link_place[at], kind="stable")]
    group: list[int] = []
    for k in [*order.tolist(), -1]:
        if group and (k < 0 or fragment.link_place[k] - fragment.link_place[group[-1]] > REACH / 2):
            images = len(np.unique(image[fragment.link_row[group]]))
            middle = float(np.median(fragment.link_place[group]))
            near = np.abs(fragment.link_place - middle) <= REACH
            if images >= max(FEWEST_IMAGES, 0.5 * len(np.unique(image[fragment.link_row[near]]))):
                cuts.append(middle)
            group = []
        group.append(k)
    return _parts(fragment, cuts) if cuts else [fragment]


def _parts(fragment: Fragment, cuts: list[float]) -> list[Fragment]:
    bounds = [-np.inf, *cuts, np.inf]
    found = []
    place = np.arange(len(fragment))
    for low, high in pairwise(bounds):
        own = np.flatnonzero((place >= low) & (place <= high))
        if len(own) < FEWEST:
            continue
        linked = (fragment.link_place >= low) & (fragment.link_place <= high)
        found.append(
            Fragment(
                fragment.xyz[own], fragment.dispersion[own], fragment.image_count[own], fragment.weak[own],
                fragment.link_row[linked], np.clip(fragment.link_place[linked] - own[0], 0.0, len(own) - 1.0),
                False, fragment.reference_image,
            )
        )  # fmt: skip
    return found
