"""Depths of a point on which chains of several images agree, and how much that is worth.

Every hypothesis gathers from each other image the one nearest to it in depth, if depth and slope agree within a gate.
An image that agrees within sigma of a depth, where a chance chain would cross anywhere within a width w, is worth

    log(w / (sigma sqrt(2 pi))) - z^2 / 2

the logarithm of the ratio of the densities of a right and of a chance crossing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

STATES = 8  # depths of a point that are kept
LARGEST_WORTH = 6.0  # of one image
ALONE = 0.3  # worth of a depth that one image gives
PAIRS = 4_000_000  # looked at in one go


@dataclass(frozen=True)
class Depths:
    """Alternative depths of points, sorted by point, best first."""

    point: IntArray  # (k,) of the chains
    depth: FloatArray  # (k,)
    sigma: FloatArray  # (k,)
    slope: FloatArray  # (k,)
    slope_sigma: FloatArray  # (k,)
    worth: FloatArray  # (k,)
    member: IntArray  # (k, partners) hypothesis of every partner image, -1: none

    def __len__(self) -> int:
        return len(self.point)


def agreed_depths(found: Hypotheses, partners: IntArray, depths: FloatArray, gate: float) -> Depths:
    """Alternative depths of the points of one image.

    Parameters
    ----------
    partners : (q,) images that were crossed
    depths : (2,) range that was searched
    gate : in sigma, of agreement
    """
    column = np.full(int(partners.max()) + 1, -1)
    column[partners] = np.arange(len(partners))
    column = column[found.image]
    _, index, size = np.unique(found.point, return_inverse=True, return_counts=True)
    crossed = np.zeros((len(size), len(partners)))
    np.add.at(crossed, (index, column), 1.0)
    width = (depths[1] - depths[0]) / (1.0 + crossed)
    member = np.full((len(found), len(partners)), -1)
    member[np.arange(len(found)), column] = np.arange(len(found))
    worth = np.full(len(found), ALONE)
    start = np.concatenate([[0], np.cumsum(size)])
    for seed, other in _near_pairs(found, index, start, depths, gate):
        z, good = _agreement(found, seed, other, gate)
        good &= column[seed] != column[other]
        seed, other, z = seed[good], other[good], z[good]
        order = np.lexsort((z, column[other], seed))
        seed, other, z = seed[order], other[order], z[order]
        new = np.ones(len(seed), dtype=bool)
        new[1:] = (seed[1:] != seed[:-1]) | (column[other][1:] != column[other][:-1])
        seed, other, z = seed[new], other[new], z[new]
        member[seed, column[other]] = other
        sigma = np.hypot(found.sigma[seed], found.sigma[other])
        value = np.log(width[index[seed], column[other]] / (sigma * np.sqrt(2.0 * np.pi))) - 0.5 * z**2
        np.add.at(worth, seed, np.clip(value, 0.0, LARGEST_WORTH))
    return _states(found, member, worth, index, start)


def _near_pairs(
    found: Hypotheses, index: IntArray, start: IntArray, depths: FloatArray, gate: float
) -> Iterator[tuple[IntArray, IntArray]]:
    """Ordered pairs of hypotheses of the same point that can agree, in blocks that hold whole points.

    A pair that agrees lies within gate sqrt(2) times the larger of its sigmas: every hypothesis looks in its own such
    window for those that are no less certain.
    """
    scale = 0.5 / (depths[1] - depths[0])
    key = index + (found.depth - depths[0]) * scale
    reach = np.sqrt(2.0) * gate * found.sigma * scale
    first = np.maximum(np.searchsorted(key, key - reach), start[:-1][index])
    last = np.minimum(np.searchsorted(key, key + reach, side="right"), start[1:][index])
    count = last - first
    total = np.concatenate([[0], np.cumsum(count)])[start]
    cuts = np.searchsorted(total, np.arange(PAIRS, int(total[-1]), PAIRS))
    edges = np.unique(np.concatenate([[0], cuts, [len(start) - 1]]))
    for begin, end in pairwise(edges):
        own = np.arange(start[begin], start[end])
        seed = np.repeat(own, count[own])
        within = np.arange(len(seed)) - np.repeat(np.cumsum(count[own]) - count[own], count[own])
        other = first[seed] + within
        sure = (found.sigma[other] < found.sigma[seed]) | (found.sigma[other] == found.sigma[seed]) & (
            other < seed
        )
        seed, other = seed[sure], other[sure]
        yield np.concatenate([seed, other]), np.concatenate([other, seed])


def _agreement(
    found: Hypotheses, seed: IntArray, other: IntArray, gate: float
) -> tuple[FloatArray, BoolArray]:
    """Difference of depth over its sigma, and whether depth and slope agree."""
    z = (found.depth[seed] - found.depth[other]) / np.hypot(found.sigma[seed], found.sigma[other])
    slope_sigma = np.hypot(found.slope_sigma[seed], found.slope_sigma[other])
    slope = (found.slope[seed] - found.slope[other]) / slope_sigma
    return np.abs(z), (np.abs(z) < gate) & (np.abs(slope) < gate)


def _states(
    found: Hypotheses, member: IntArray, worth: FloatArray, index: IntArray, start: IntArray
) -> Depths:
    """The best depths of every point; a hypothesis that a better one has gathered gives none of its own."""
    order = np.lexsort((-worth, index))
    taken = np.zeros(len(found), dtype=bool)
    rank = np.zeros(len(start) - 1, dtype=np.int64)
    kept = []
    place = np.arange(len(order)) - start[:-1][index[order]]
    for number in range(int(place.max()) + 1 if len(place) else 0):
        seeds = order[place == number]
        seeds = seeds[~taken[seeds] & (rank[index[seeds]] < STATES)]
        own = member[seeds]
        taken[own[own >= 0]] = True
        rank[index[seeds]] += 1
        kept.append(seeds)
    seeds = np.concatenate(kept) if kept else np.zeros(0, dtype=np.int64)
    seeds = seeds[np.lexsort((-worth[seeds], index[seeds]))]
    members = member[seeds]
    present = members >= 0
    weight = np.where(present, 1.0 / found.sigma[members] ** 2, 0.0)
    slope_weight = np.where(present, 1.0 / found.slope_sigma[members] ** 2, 0.0)
    total, slope_total = weight.sum(axis=1), slope_weight.sum(axis=1)
    return Depths(
        point=found.point[seeds],
        depth=(weight * found.depth[members]).sum(axis=1) / total,
        sigma=1.0 / np.sqrt(total),
        slope=(slope_weight * found.slope[members]).sum(axis=1) / slope_total,
        slope_sigma=1.0 / np.sqrt(slope_total),
        worth=worth[seeds],
        member=members,
    )
