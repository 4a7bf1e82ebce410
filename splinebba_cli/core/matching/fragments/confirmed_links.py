"""Links that both sides and a stretch of both chains confirm.

A link from a point of one image to a place of another is mutual where the points beside that place are linked back to
the piece of the point.  A chain that touches a run in a point or two is there by chance.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, IntArray

STRETCH = 3  # consecutive points of a piece that must be linked to one other piece


def confirmed(chains: TracedChains, labels: LabelledPoints, partners: list[IntArray]) -> LabelledPoints:
    """The labels with the links that hold from both sides over a stretch."""
    labels = labels.with_links(_over_a_stretch(chains, labels))
    labels = labels.with_links(_mutual(chains, labels, partners))
    return labels.with_links(_over_a_stretch(chains, labels))


def _mutual(chains: TracedChains, labels: LabelledPoints, partners: list[IntArray]) -> BoolArray:
    """Links that are returned; links to images that are not compared with the own one count as returned."""
    pieces = len(chains.start)
    point, place = labels.link_point, labels.link_place.astype(np.int64)
    back = np.unique(point * pieces + chains.piece[place])
    own = chains.piece[point]
    after = np.minimum(place + 1, chains.start[chains.piece[place] + 1] - 1)
    returned = np.isin(place * pieces + own, back) | np.isin(after * pieces + own, back)
    images = len(partners)
    compared = np.concatenate([np.asarray(each) + k * images for k, each in enumerate(partners)])
    asked = np.isin(chains.image[place] * images + chains.image[point], compared)
    return np.asarray(returned | ~asked)


def _over_a_stretch(chains: TracedChains, labels: LabelledPoints) -> BoolArray:
    """Links that belong to a row of consecutive points linked to the same piece; a point may be left out."""
    point, piece = labels.link_point, chains.piece[labels.link_place.astype(np.int64)]
    own = chains.piece[point]
    order = np.lexsort((point, piece, own))
    new = np.ones(len(order), dtype=bool)
    one, two = order[:-1], order[1:]
    new[1:] = (own[one] != own[two]) | (piece[one] != piece[two]) | (point[two] - point[one] > 2)
    group = np.cumsum(new) - 1
    size = np.bincount(group)
    whole = np.minimum(STRETCH, np.diff(chains.start)[own[order]])
    keep = np.zeros(len(order), dtype=bool)
    keep[order] = size[group] >= np.maximum(whole, 2)
    return keep
