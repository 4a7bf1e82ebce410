"""One depth for every point of a piece: the sequence of depths worth most (dynamic programming, Viterbi).

    maximise  sum worth(s) - sum cost(s, s + 1),
    cost = min(z^2 / 2, BREAK) - SHARED [both are crossings of the same chain],
    z = (depth' - depth - h (slope + slope') / 2) / sigma

over h millimetres along the chain.  "No depth" is a state of worth 0; to enter and to leave it costs half a break.
All pieces of an image are worked on side by side, point by point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.consensus import STATES, Depths
from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

BREAK = 6.0  # what a jump in depth costs: half a square of 3.5 sigma
SHARED = 1.0  # what it is worth to stay on the same chain of another image
NONE = STATES  # number of the state "no depth"


@dataclass(frozen=True)
class _Table:
    """Alternative depths of the points of an image, padded: values (n, STATES), pieces (n, STATES, partners)."""

    depth: FloatArray
    sigma: FloatArray
    slope: FloatArray
    slope_sigma: FloatArray
    worth: FloatArray  # (n, STATES + 1), the last is "no depth"; -inf: no such state
    piece: IntArray  # of the crossed chains, -1: none


def best_depths(
    chains: TracedChains, found: Hypotheses, depths: Depths, points: IntArray
) -> tuple[IntArray, BoolArray]:
    """The depths of all points of an image.

    Parameters
    ----------
    points : (n,) all points of the image, consecutive

    Returns
    -------
    state : (n,) index into `depths`, -1: no depth
    joined : (n,) whether the depth continues that of the point before
    """
    begin = np.searchsorted(depths.point, points)
    table = _table(chains, found, depths, points)
    start = chains.start[chains.piece[points[0]] : chains.piece[points[-1]] + 2] - points[0]
    order = np.argsort(-np.diff(start), kind="stable")
    first, length = start[:-1][order], np.diff(start)[order]
    step = np.diff(chains.arc[points], prepend=0.0)
    back = np.full((len(points), STATES + 1), -1)
    smooth = np.zeros(back.shape, dtype=bool)
    total = table.worth[first]
    ends = np.zeros(len(first), dtype=np.int64)
    for k in range(int(length[0])):
        active = int(np.searchsorted(-length, -k))
        if k:
            now = first[:active] + k
            cost, joins = _transition(table, now, step[now])
            gain = total[:active, :, None] - cost
            best = np.argmax(gain, axis=1)
            back[now] = best
            smooth[now] = np.take_along_axis(joins, best[:, None], axis=1)[:, 0]
            total[:active] = np.take_along_axis(gain, best[:, None], axis=1)[:, 0] + table.worth[now]
        over = length[:active] == k + 1
        ends[:active][over] = np.argmax(total[:active][over], axis=1)
    state = _traced_back(first, length, ends, back)
    has = state != NONE
    joined = smooth[np.arange(len(points)), state] & has
    return np.where(has, begin + state, -1), joined


def _table(chains: TracedChains, found: Hypotheses, depths: Depths, points: IntArray) -> _Table:
    point = depths.point - points[0]
    rank = np.arange(len(point)) - np.searchsorted(depths.point, depths.point)
    values = np.ones((4, len(points), STATES))
    for value, given in zip(
        values, (depths.depth, depths.sigma, depths.slope, depths.slope_sigma), strict=True
    ):
        value[point, rank] = given
    worth = np.full((len(points), STATES + 1), -np.inf)
    worth[point, rank] = depths.worth
    worth[:, NONE] = 0.0
    piece = np.full((len(points), STATES, depths.member.shape[1]), -1)
    of_place = chains.piece[found.place.astype(np.int64)]
    piece[point, rank] = np.where(depths.member >= 0, of_place[depths.member], -1)
    depth, sigma, slope, slope_sigma = values
    return _Table(depth, sigma, slope, slope_sigma, worth, piece)


def _transition(table: _Table, now: IntArray, step: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Cost from every state of the points before to every one of points, and whether the depth goes on smoothly.

    Both are (a, STATES + 1, STATES + 1).
    """
    cost = np.full((len(now), STATES + 1, STATES + 1), 0.5 * BREAK)
    cost[:, NONE, NONE] = 0.0
    smooth = np.zeros(cost.shape, dtype=bool)
    before = now - 1
    z = depth_jump(
        table.depth[before][:, :, None], table.sigma[before][:, :, None], table.slope[before][:, :, None],
        table.slope_sigma[before][:, :, None], table.depth[now][:, None], table.sigma[now][:, None],
        table.slope[now][:, None], table.slope_sigma[now][:, None], step[:, None, None],
    )  # fmt: skip
    jump = 0.5 * z**2
    same = np.zeros(jump.shape, dtype=bool)
    for one, two in zip(
        table.piece[before].transpose(2, 0, 1), table.piece[now].transpose(2, 0, 1), strict=True
    ):
        same |= (one[:, :, None] == two[:, None]) & (one[:, :, None] >= 0)
    smooth[:, :NONE, :NONE] = jump < BREAK
    cost[:, :NONE, :NONE] = np.where(jump < BREAK, jump - SHARED * same, BREAK)
    return cost, smooth


def _traced_back(first: IntArray, length: IntArray, ends: IntArray, back: IntArray) -> IntArray:
    """The states of all points, from the last of every piece to its first, (n,)."""
    state = np.full(len(back), NONE)
    current = ends.copy()
    for k in range(int(length[0]) - 1, -1, -1):
        active = int(np.searchsorted(-length, -k))
        now = first[:active] + k
        state[now] = current[:active]
        if k:
            current[:active] = back[now, current[:active]]
    return state


def depth_jump(
    depth: FloatArray, sigma: FloatArray, slope: FloatArray, slope_sigma: FloatArray,
    next_depth: FloatArray, next_sigma: FloatArray, next_slope: FloatArray, next_slope_sigma: FloatArray,
    step: float | FloatArray,
) -> FloatArray:  # fmt: skip
    """Change of depth that slopes do not explain, over its sigma."""
    unexplained = next_depth - depth - 0.5 * step * (slope + next_slope)
    variance = sigma**2 + next_sigma**2 + (0.5 * step) ** 2 * (slope_sigma**2 + next_slope_sigma**2)
    return np.asarray(unexplained / np.sqrt(variance))
