"""Directions of edges along chains: the principal axis of neighbouring points, and its standard deviation.

Over n points at equal distances along a length L the direction of a fitted line has sigma^2 = 12 sigma_xy^2 / (n L^2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

LONG_ENOUGH = 12.0  # sigma of a point: length over which a direction is taken
MOST = 25  # points to either side
FEWEST = 3  # points of a chain that tells directions: two say nothing of how it bends
TURNING = (
    0.6  # of what the direction turns over half a window: where an edge bends, its chord is not its tangent
)
FOLD, FOLD_SIGMA = 1.0, 4.0  # rad, and its own sigma: of a turn at a point through which no line is fitted
GIVEN_SIGMA = 0.1  # rad, of directions that come with the points


@dataclass(frozen=True)
class Directions:
    """Directions up to half a turn; NaN and inf where unknown."""

    angle: FloatArray  # (n,) rad
    sigma: FloatArray  # (n,) rad


@dataclass(frozen=True)
class ChainOrder:
    """Points chain by chain in the order of tracing; single points are chains of one."""

    order: IntArray  # (p,) points, chain after chain
    begin: IntArray  # (p,) place in `order` of the first point of the chain that a place belongs to
    end: IntArray  # (p,) one behind the last
    position: IntArray  # (p,) number of a place inside its chain

    @classmethod
    def of(cls, chain: IntArray, usable: BoolArray | None = None) -> ChainOrder:
        """Of chain numbers (n,), -1 for single points.

        Parameters
        ----------
        usable : (n,) points that are there at all; their chains go on where others are left out
        """
        count = len(chain)
        own = np.where(chain < 0, chain.max(initial=-1) + 1 + np.arange(count), chain)
        order = np.argsort(own, kind="stable")
        if usable is not None:
            order = order[usable[order]]
            count = len(order)
        change = np.flatnonzero(np.diff(own[order], prepend=-1 if count else 0))
        size = np.diff(np.append(change, count))
        begin, end = np.repeat(change, size), np.repeat(change + size, size)
        return cls(order, begin, end, np.arange(count) - begin)

    def with_some(self, wanted: BoolArray) -> ChainOrder:
        """Chains that have a wanted point, whole.

        Parameters
        ----------
        wanted : (n,) of all points
        """
        number = np.cumsum(self.position == 0) - 1
        kept = np.bincount(number, wanted[self.order]) > 0
        places = kept[number]
        before = np.cumsum(places) - places
        begin = before[self.begin[places]]
        size = (self.end - self.begin)[places]
        return ChainOrder(self.order[places], begin, begin + size, self.position[places])


@dataclass(frozen=True)
class Traced:
    """What tracing tells of points, whatever the orientations are."""

    order: ChainOrder
    directions: Directions

    @classmethod
    def of(cls, scene: Scene, usable: BoolArray) -> Traced:
        """Of the usable points (n,) of a scene."""
        order = ChainOrder.of(scene.chain, usable)
        return cls(order, chain_directions(scene, order))


def chain_directions(scene: Scene, chains: ChainOrder) -> Directions:
    """Directions of all points: as given, else from their chains."""
    order = chains.order
    xy = scene.xy[order]
    sigma = _round_sigma(scene.whitening)[order]
    half = _half_width(xy, sigma, chains)
    low, high = (
        np.maximum(chains.begin, chains.position + chains.begin - half),
        np.minimum(chains.end, chains.position + chains.begin + half + 1),
    )
    count = high - low
    centred = xy - xy[chains.begin] if len(xy) else xy

    def total(values: FloatArray) -> FloatArray:
        sums = np.concatenate([[0.0], np.cumsum(values)])
        return np.asarray(sums[high] - sums[low])

    mean = np.stack([total(centred[:, 0]), total(centred[:, 1])], axis=1) / count[:, None]
    xx = total(centred[:, 0] ** 2) / count - mean[:, 0] ** 2
    yy = total(centred[:, 1] ** 2) / count - mean[:, 1] ** 2
    mixed = total(centred[:, 0] * centred[:, 1]) / count - mean[:, 0] * mean[:, 1]
    angle, deviation = np.full(len(scene.xy), np.nan), np.full(len(scene.xy), np.inf)
    spread = xx + yy
    enough = (count >= 2) & (spread > 4.0 * sigma**2)
    enough &= chains.end - chains.begin >= FEWEST
    axis = np.where(enough, 0.5 * np.arctan2(2.0 * mixed, xx - yy), np.nan)
    angle[order] = axis
    with np.errstate(divide="ignore", invalid="ignore"):
        noise = np.where(enough, sigma / np.sqrt(count * spread), np.inf)
    turning = np.fmax(_turning(axis, half, chains), _folds(xy, sigma, half, chains))
    deviation[order] = np.hypot(noise, TURNING * turning)
    given = np.isfinite(scene.direction)
    return Directions(np.where(given, scene.direction, angle), np.where(given, GIVEN_SIGMA, deviation))


def _round_sigma(whitening: FloatArray) -> FloatArray:
    """Mean standard deviation of points from their whitening, (n,) mm."""
    return np.asarray(1.0 / np.sqrt(np.abs(np.linalg.det(whitening)))) if len(whitening) else np.zeros(0)


def _half_width(xy: FloatArray, sigma: FloatArray, chains: ChainOrder) -> IntArray:
    """Points to either side over which a direction is taken, (n,), the same for all points of a chain."""
    if not len(xy):
        return np.zeros(0, dtype=np.int64)
    step = np.linalg.norm(np.diff(xy, axis=0, prepend=xy[:1]), axis=1)
    step[chains.position == 0] = 0.0
    start = np.flatnonzero(chains.position == 0)
    size = chains.end[start] - start
    noise = np.add.reduceat(sigma, start) / size
    square = (
        np.add.reduceat(step**2, start) / np.maximum(size - 1, 1) - 4.0 * noise**2
    )  # without the noise of both
    half = np.ceil(0.5 * LONG_ENOUGH * noise / np.sqrt(np.maximum(square, 1e-24)))
    return np.repeat(np.clip(half, 1, MOST).astype(np.int64), size)


def _turning(axis: FloatArray, half: IntArray, chains: ChainOrder) -> FloatArray:
    """Largest change of direction towards half a window before and behind every place, (n,) rad."""
    place = np.arange(len(axis))
    found = np.zeros(len(axis))
    for other in (np.maximum(place - half, chains.begin), np.minimum(place + half, chains.end - 1)):
        found = np.fmax(found, np.abs(np.arcsin(np.clip(np.sin(axis[other] - axis), -1.0, 1.0))))
    return found


def _folds(xy: FloatArray, sigma: FloatArray, half: IntArray, chains: ChainOrder) -> FloatArray:
    """Largest sharp change between the ways over half a window, at a place or half a window beside it, (n,) rad.

    Where an edge folds, as an ellipse does that is seen from the side, the principal axis runs along the fold before
    and behind it, and across the tangent at it.
    """
    place = np.arange(len(xy))
    before, behind = np.maximum(place - half, chains.begin), np.minimum(place + half, chains.end - 1)
    to, on = xy - xy[before], xy[behind] - xy
    across = to[:, 0] * on[:, 1] - to[:, 1] * on[:, 0]
    bend = np.abs(np.arctan2(across, np.sum(to * on, axis=1)))
    with np.errstate(divide="ignore"):
        short = sigma / np.minimum(np.linalg.norm(to, axis=1), np.linalg.norm(on, axis=1))
    sharp = bend > np.maximum(FOLD, FOLD_SIGMA * np.sqrt(6.0) * short)
    fold = np.where((place - before == half) & (behind - place == half) & sharp, bend, 0.0)
    return np.asarray(np.maximum(fold, np.maximum(fold[before], fold[behind])))
