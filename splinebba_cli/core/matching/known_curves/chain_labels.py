"""Curves of the points of chains, by dynamic programming: a chain votes as a whole.

States of a point are its nearest candidates and "none".  The labels of a chain make least

    sum of d^2 / var d + turn^2 / (tolerance^2 + var turn)   of points on a curve,   a fixed cost of points on none,
    + a cost for every change of state.

Two neighbours stay on a curve where their offsets from it differ no more than noise and the stretch between them allow:
the foot point then moves along with the point, in order; a jump on the same curve is a change.  So a chain that runs
over two curves is split where it leaves the one, parts that no curve explains are left out, and single points are
chains of one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.known_curves.chain_directions import ChainOrder
from splinebba_cli.core.matching.known_curves.gates import Gated
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

STATES = 6  # candidates of a point that take part
CHANGE = 16.0  # from curve to curve; half of it from a curve to none and back
STRETCH = 0.5  # of the distance of neighbours: how much more or less the foot point may move
JITTER = 6.0  # sigma of a point, of the difference of two offsets


@dataclass(frozen=True)
class _States:
    """Candidates of every point in columns, nearest first; places chain by chain."""

    row: IntArray  # (n, K) candidate, -1: none
    cost: FloatArray  # (n, K) inf where there is none
    curve: IntArray  # (n, K)
    offset: FloatArray  # (n, K, 2)


def label_chains(
    scene: Scene, gated: Gated, chains: ChainOrder, allowed: BoolArray, none_cost: float, tolerance: float
) -> IntArray:
    """The candidate of every point, (n,), -1: none.

    Parameters
    ----------
    chains : that get labels
    allowed : (k,) candidates that may be taken
    none_cost : of a point on no curve
    tolerance : rad, of directions
    """
    label = np.full(len(scene.image), -1)
    count = len(chains.order)
    states = _states(gated, chains, allowed, tolerance, len(label))
    if not states.row.shape[1] or not count:
        return label
    order = chains.order
    step = np.linalg.norm(np.diff(scene.xy[order], axis=0, prepend=scene.xy[order[:1]]), axis=1)
    sigma = 1.0 / np.sqrt(np.abs(np.linalg.det(scene.whitening[order])))
    by_position = np.argsort(chains.position, kind="stable")
    bounds = np.concatenate([[0], np.cumsum(np.bincount(chains.position))])
    width = states.row.shape[1]
    total = np.full((count, width + 1), none_cost)
    total[:, :width] = states.cost
    came_from = np.full((count, width + 1), width, dtype=np.int8)
    for t in range(1, len(bounds) - 1):
        place = by_position[bounds[t] : bounds[t + 1]]
        change = _change_costs(states, place, STRETCH * step[place] + JITTER * sigma[place])
        arrival = total[place - 1][:, :, None] + change
        came_from[place] = np.argmin(arrival, axis=1)
        best = np.min(arrival, axis=1)
        total[place] += best
    return _traced_back(label, states, chains, total, came_from)


def _states(gated: Gated, chains: ChainOrder, allowed: BoolArray, tolerance: float, count: int) -> _States:
    """The best candidates of every point, in the order of chains."""
    turn = np.nan_to_num(gated.turn) / np.hypot(tolerance, gated.turn_sigma)
    cost = gated.square + turn**2
    place_of = np.full(count, -1)
    place_of[chains.order] = np.arange(len(chains.order))
    rows = np.flatnonzero(allowed & (place_of[gated.candidates.point] >= 0))
    point = gated.candidates.point[rows]
    rows = rows[np.lexsort((cost[rows], point))]
    point = gated.candidates.point[rows]
    number = np.arange(len(rows)) - np.searchsorted(point, point)
    rows, point, number = rows[number < STATES], point[number < STATES], number[number < STATES]
    width = int(number.max(initial=-1)) + 1
    row = np.full((len(chains.order), width), -1)
    row[place_of[point], number] = rows
    empty = row < 0
    if not len(cost):
        return _States(row, np.zeros(row.shape), row, np.zeros((*row.shape, 2)))
    return _States(
        row,
        np.where(empty, np.inf, cost[row]),
        np.where(empty, -1, gated.candidates.curve[row]),
        np.where(empty[:, :, None], np.inf, gated.candidates.offset[row]),
    )


def _change_costs(states: _States, place: IntArray, slack: FloatArray) -> FloatArray:
    """Cost of going from each state of the point before to each state of a point, (g, K + 1, K + 1)."""
    width = states.row.shape[1]
    change = np.full((len(place), width + 1, width + 1), CHANGE)
    with np.errstate(invalid="ignore"):
        moved = states.offset[place][:, None] - states.offset[place - 1][:, :, None]
        smooth = np.abs(moved).max(axis=3) <= slack[:, None, None]
    same = states.curve[place][:, None, :] == states.curve[place - 1][:, :, None]
    change[:, :width, :width] = np.where(same & smooth, 0.0, CHANGE)
    change[:, width, :] = change[:, :, width] = 0.5 * CHANGE
    change[:, width, width] = 0.0
    return change


def _traced_back(
    label: IntArray, states: _States, chains: ChainOrder, total: FloatArray, came_from: IntArray
) -> IntArray:
    """Labels from the ends of the chains back to their beginnings."""
    count, width = states.row.shape
    state = np.full(count, width)
    size = chains.end - chains.begin
    left = size - 1 - chains.position  # 0 at the end of a chain
    from_end = np.argsort(left, kind="stable")
    bounds = np.concatenate([[0], np.cumsum(np.bincount(left))])
    for t in range(len(bounds) - 1):
        place = from_end[bounds[t] : bounds[t + 1]]
        if t == 0:
            state[place] = np.argmin(total[place], axis=1)
        else:
            state[place] = came_from[place + 1, state[place + 1]]
    taken = np.flatnonzero(state < width)
    label[chains.order[taken]] = states.row[taken, state[taken]]
    return label
