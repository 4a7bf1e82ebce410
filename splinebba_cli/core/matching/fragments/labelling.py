"""One depth for every point of a piece: the sequence of depths worth most (dynamic programming, Viterbi).

    maximise  sum worth(s) - sum cost(s, s + 1),
    cost = min(z^2 / 2, BREAK) - SHARED [both are crossings of the same chains],
    z = (depth' - depth - h (slope + slope') / 2) / sigma

over h millimetres along the chain.  "No depth" is a state of worth 0; to enter and to leave it costs half a break.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.consensus import Depths
from splinebba_cli.core.matching.fragments.hypotheses import Hypotheses
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

BREAK = 6.0  # what a jump in depth costs: half a square of 3.5 sigma
SHARED = 1.0  # what it is worth to stay on the same chain of another image


def best_depths(
    chains: TracedChains, found: Hypotheses, depths: Depths, first: int, last: int
) -> tuple[IntArray, BoolArray]:
    """The depths of points first to last - 1, all of one piece.

    Returns
    -------
    state : (n,) index into `depths`, -1: no depth
    joined : (n,) whether the depth continues that of the point before
    """
    begin = np.searchsorted(depths.point, np.arange(first, last))
    end = np.searchsorted(depths.point, np.arange(first, last), side="right")
    step = np.diff(chains.arc[first:last], prepend=chains.arc[first])
    score = np.append(depths.worth[begin[0] : end[0]], 0.0)
    back, joined = [np.full(len(score), -1)], [np.zeros(len(score), dtype=bool)]
    for k in range(1, last - first):
        before, now = np.arange(begin[k - 1], end[k - 1]), np.arange(begin[k], end[k])
        cost, smooth = _transition(chains, found, depths, before, now, float(step[k]))
        total = score[:, None] - cost
        best = np.argmax(total, axis=0)
        column = np.arange(len(best))
        score = total[best, column] + np.append(depths.worth[now], 0.0)
        back.append(best)
        joined.append(smooth[best, column])
    state = np.full(last - first, -1)
    smooth_to = np.zeros(last - first, dtype=bool)
    current = int(np.argmax(score))
    for k in range(last - first - 1, -1, -1):
        smooth_to[k] = joined[k][current]
        state[k] = begin[k] + current if current < end[k] - begin[k] else -1
        current = int(back[k][current])
    return state, smooth_to


def _transition(
    chains: TracedChains, found: Hypotheses, depths: Depths, before: IntArray, now: IntArray, step: float
) -> tuple[FloatArray, BoolArray]:
    """Cost from every state to every next one, the last is "no depth", and whether the depth goes on smoothly."""
    cost = np.full((len(before) + 1, len(now) + 1), 0.5 * BREAK)
    cost[-1, -1] = 0.0
    smooth = np.zeros(cost.shape, dtype=bool)
    if len(before) and len(now):
        z = depth_jump(
            depths.depth[before][:, None], depths.sigma[before][:, None], depths.slope[before][:, None],
            depths.slope_sigma[before][:, None], depths.depth[now], depths.sigma[now], depths.slope[now],
            depths.slope_sigma[now], step,
        )  # fmt: skip
        jump = 0.5 * z**2
        same = _on_same_chain(chains, found, depths.member[before], depths.member[now])
        smooth[:-1, :-1] = jump < BREAK
        cost[:-1, :-1] = np.where(jump < BREAK, jump - SHARED * same, BREAK)
    return cost, smooth


def depth_jump(
    depth: FloatArray, sigma: FloatArray, slope: FloatArray, slope_sigma: FloatArray,
    next_depth: FloatArray, next_sigma: FloatArray, next_slope: FloatArray, next_slope_sigma: FloatArray,
    step: float | FloatArray,
) -> FloatArray:  # fmt: skip
    """Change of depth that slopes do not explain, over its sigma."""
    unexplained = next_depth - depth - 0.5 * step * (slope + next_slope)
    variance = sigma**2 + next_sigma**2 + (0.5 * step) ** 2 * (slope_sigma**2 + next_slope_sigma**2)
    return np.asarray(unexplained / np.sqrt(variance))


def _on_same_chain(
    chains: TracedChains, found: Hypotheses, before: IntArray, now: IntArray
) -> BoolArray:
    """Whether two states have a piece in common, (k, l)."""
    one = np.where(before >= 0, chains.piece[found.place[before].astype(np.int64)], -1)
    two = np.where(now >= 0, chains.piece[found.place[now].astype(np.int64)], -2)
    return np.asarray((one[:, None, :] == two[None, :, :]).any(axis=2))
