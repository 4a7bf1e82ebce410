"""Runs: stretches of a piece along which the depth goes on, bridged where the images leave it open."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.labelling import depth_jump
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

SHORT_GAP = 3  # points without depth that are bridged at any rate
LONG_GAP = 40  # points that are bridged where a chain of another image goes on beside them
BRIDGE_SIGMA = 4.0
TURN_OVER_GAP = 1.0 / 16.0  # of the gap: sagitta of a curve that turns by half a radian in it


@dataclass(frozen=True)
class Runs:
    """Ranges of chain points, and the depths of the points in them."""

    first: IntArray  # (r,)
    last: IntArray  # (r,) one behind the last point
    depth: FloatArray  # (n,) of all chain points; of bridged ones interpolated
    sigma: FloatArray  # (n,)
    bridged: BoolArray  # (n,)

    def __len__(self) -> int:
        return len(self.first)


def runs_of(chains: TracedChains, labels: LabelledPoints) -> Runs:
    """Runs of all pieces."""
    has = np.isfinite(labels.depth)
    begins = has & ~(labels.joined & np.concatenate([[False], has[:-1]]))
    begins[chains.start[:-1][has[chains.start[:-1]]]] = True
    ends = has.copy()
    ends[:-1] &= ~has[1:] | begins[1:]
    first, last = np.flatnonzero(begins), np.flatnonzero(ends)
    depth, sigma = labels.depth.copy(), labels.sigma.copy()
    bridged = np.zeros(len(has), dtype=bool)
    kept_first: list[int] = []
    kept_last: list[int] = []
    begin = np.searchsorted(labels.link_point, np.arange(len(chains) + 1))
    for a, b in zip(first.tolist(), last.tolist(), strict=True):
        if kept_last and _goes_on(chains, labels, begin, kept_last[-1], a):
            _bridge(chains, labels, kept_last[-1], a, depth, sigma, bridged)
            kept_last[-1] = b
        else:
            kept_first.append(a)
            kept_last.append(b)
    return Runs(
        np.array(kept_first, dtype=np.int64), np.array(kept_last, dtype=np.int64) + 1, depth, sigma, bridged
    )


def _linked_pieces(chains: TracedChains, labels: LabelledPoints, begin: IntArray, point: int) -> IntArray:
    """Pieces that a point is linked to."""
    return chains.piece[labels.link_place[begin[point] : begin[point + 1]].astype(np.int64)]


def _goes_on(chains: TracedChains, labels: LabelledPoints, begin: IntArray, before: int, after: int) -> bool:
    """Whether the depths before and after a gap belong to one curve."""
    gap = after - before - 1
    if chains.piece[before] != chains.piece[after] or gap > LONG_GAP:
        return False
    if gap > SHORT_GAP:
        one, two = (_linked_pieces(chains, labels, begin, point) for point in (before, after))
        if not np.isin(one, two).any():
            return False
    step = chains.arc[after] - chains.arc[before]
    free = labels.depth[before] * step * TURN_OVER_GAP / _in_depth(chains, labels, before)
    jump = depth_jump(
        labels.depth[before], np.hypot(labels.sigma[before], free), labels.slope[before], labels.slope_sigma[before],
        labels.depth[after], labels.sigma[after], labels.slope[after], labels.slope_sigma[after], step,
    )  # fmt: skip
    return bool(abs(jump) < BRIDGE_SIGMA)


def _in_depth(chains: TracedChains, labels: LabelledPoints, point: int) -> float:
    """Length of the ray of a point, mm: a metre across it is 1 / (length) of depth along it."""
    return float(np.linalg.norm(chains.ray[point]))


def _bridge(
    chains: TracedChains, labels: LabelledPoints, before: int, after: int,
    depth: FloatArray, sigma: FloatArray, bridged: BoolArray,
) -> None:  # fmt: skip
    """Depths of the points of a gap: straight from its one end to the other, with sigma of a curve's sagitta."""
    points = np.arange(before + 1, after)
    if not len(points):
        return
    total = chains.arc[after] - chains.arc[before]
    share = (chains.arc[points] - chains.arc[before]) / total
    depth[points] = (1.0 - share) * labels.depth[before] + share * labels.depth[after]
    ends = np.hypot((1.0 - share) * labels.sigma[before], share * labels.sigma[after])
    sagitta = labels.depth[before] * total * TURN_OVER_GAP / _in_depth(chains, labels, before)
    sigma[points] = np.hypot(ends, 4.0 * share * (1.0 - share) * sagitta)
    bridged[points] = True
