"""Runs: stretches of a chain on one curve, judged as a whole.

The distances of the N points of a run from its curve have an error in common, of variance t (orientation, shape), and
noise of variance s each, of which a part may be common too (edges are traced with a bias b).  With mean m and spread v

    -2 ln L = N v / s + m^2 / (t + s / N + b^2 s) + ln((t + s / N + b^2 s) / s)

compares the curve with its rivals; a mean or a slope that such errors do not explain says that the chain follows
something else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from splinebba_cli.core.matching.known_curves.chain_directions import ChainOrder
from splinebba_cli.core.matching.known_curves.gates import Gated
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

TRACING_BIAS = 0.7  # sigma of a point: common to an edge
FEWEST = 4  # points of a run of a longer chain
SHARE = 0.6  # of the points of a short chain
ODDS = 20.0  # of the curve against the next one
COVERED = 0.8  # share of a run near which another curve is a rival
SLOPE = 0.06  # of distances along a run, beyond what noise and orientation explain
SLOPE_SIGMA = 4.0
MEAN_TURN, TURN_SIGMA = 0.1, 3.0  # rad, of the mean direction of a run, and sigma of its points
EFFECTIVE = 0.2  # share of the points of a chain whose noise is independent


@dataclass(frozen=True)
class Runs:
    """Runs of labelled points."""

    of_point: IntArray  # (n,) run of a point, -1: none
    chain: IntArray  # (r,) of a point that begins it: its chain number, -1 for single points
    image: IntArray  # (r,)
    curve: IntArray  # (r,)
    count: IntArray  # (r,)
    mean: FloatArray  # (r,) mm
    cost: FloatArray  # (r,) -2 ln L
    rival_cost: FloatArray  # (r,) of the best other curve; inf where there is none
    fits: BoolArray  # (r,) mean and slope are explained, enough points

    @property
    def ambiguous(self) -> BoolArray:
        """Runs that another curve explains nearly as well, (r,)."""
        return np.asarray(self.rival_cost - self.cost < 2.0 * np.log(ODDS))


def find_runs(scene: Scene, gated: Gated, chains: ChainOrder, label: IntArray, alpha: float) -> Runs:
    """Runs of points with labels.

    Parameters
    ----------
    label : (n,) candidate of every point, -1: none
    alpha : of the test of the mean
    """
    of_point, start = _numbered(gated, chains, label)
    count_of_runs = len(start)
    rows = np.flatnonzero(of_point >= 0)
    own = _Sums.of(of_point[rows], label[rows], gated, count_of_runs)
    slope, slope_sigma = _slopes(scene, gated, chains, of_point, label, count_of_runs)
    size = own.count.astype(np.int64)
    length = np.ones(len(scene.image), dtype=np.int64)
    length[chains.order] = chains.end - chains.begin
    enough = size >= np.minimum(FEWEST, np.ceil(SHARE * length[start]))
    centred = own.mean**2 <= chdtri(1, alpha) * own.mean_variance
    level = np.abs(slope) <= SLOPE + SLOPE_SIGMA * slope_sigma
    level &= _runs_along(gated, of_point, label, count_of_runs)
    return Runs(
        of_point=of_point,
        chain=scene.chain[start],
        image=scene.image[start],
        curve=gated.candidates.curve[label[start]],
        count=size,
        mean=own.mean,
        cost=own.cost,
        rival_cost=_rivals(gated, of_point, label, own),
        fits=enough & centred & level,
    )


def _numbered(gated: Gated, chains: ChainOrder, label: IntArray) -> tuple[IntArray, IntArray]:
    """Run of every point (n,), -1: none; the first point of every run."""
    order = chains.order
    own = label[order]
    curve = np.where(own >= 0, gated.candidates.curve[np.maximum(own, 0)], -1) if len(gated.across) else own
    changed = np.diff(curve, prepend=-2) != 0
    begins = (changed | (chains.position == 0)) & (curve >= 0)
    number = np.where(curve >= 0, np.cumsum(begins) - 1, -1)
    of_point = np.full(len(label), -1)
    of_point[order] = number
    return of_point, order[begins]


@dataclass(frozen=True)
class _Sums:
    """Sums over the points of groups."""

    count: FloatArray
    mean: FloatArray
    mean_variance: FloatArray
    cost: FloatArray

    @classmethod
    def of(cls, group: IntArray, candidate: IntArray, gated: Gated, groups: int) -> _Sums:
        """Of candidates (q,) that belong to groups (q,)."""
        d, noise, common = (each[candidate] for each in (gated.across, gated.noise, gated.common))

        def total(values: FloatArray) -> FloatArray:
            return np.asarray(np.bincount(group, values, minlength=groups), dtype=np.float64)

        count = np.maximum(total(np.ones(len(d))), 1.0)
        mean, s, t = total(d) / count, total(noise) / count, total(common) / count
        spread = np.maximum(total(d * d) / count - mean**2, 0.0)
        s = np.maximum(s, 1e-300)
        bias = np.where(count > 1, TRACING_BIAS**2, 0.0)
        variance = t + s / count + bias * s
        independent = np.maximum(EFFECTIVE * count, np.minimum(count, 1.0))
        cost = independent * spread / s + mean**2 / variance + np.log(variance / s)
        return cls(count, mean, variance, cost)


def _rivals(gated: Gated, of_point: IntArray, label: IntArray, own: _Sums) -> FloatArray:
    """-2 ln L of the best other curve that passes near most of a run, (r,)."""
    point, curve = gated.candidates.point, gated.candidates.curve
    run = of_point[point] if len(point) else np.zeros(0, dtype=np.int64)
    labelled = np.flatnonzero((run >= 0) & gated.agrees)
    labelled = labelled[curve[labelled] != curve[label[point[labelled]]]]
    labelled = _nearest_branches(gated, labelled)
    cost = np.full(len(own.count), np.inf)
    if not len(labelled):
        return cost
    curves = int(curve.max()) + 1
    key = run[labelled] * curves + curve[labelled]
    kinds, group = np.unique(key, return_inverse=True)
    other = _Sums.of(group, labelled, gated, len(kinds))
    run_of = kinds // curves
    near = other.count >= COVERED * own.count[run_of]
    np.minimum.at(cost, run_of[near], other.cost[near])
    return cost


def _nearest_branches(gated: Gated, rows: IntArray) -> IntArray:
    """Of some candidates those on the nearest branch of their curve."""
    point, curve = gated.candidates.point[rows], gated.candidates.curve[rows]
    order = np.lexsort((gated.square[rows], curve, point))
    new = (np.diff(point[order], prepend=-1) != 0) | (np.diff(curve[order], prepend=-1) != 0)
    return np.asarray(rows[order[new]])


def _runs_along(gated: Gated, of_point: IntArray, label: IntArray, groups: int) -> BoolArray:
    """Runs (r,) whose mean direction is that of their curve; windows of directions overlap, so that errors remain."""
    rows = np.flatnonzero(of_point >= 0)
    rows = rows[np.isfinite(gated.turn[label[rows]])]
    run, candidate = of_point[rows], label[rows]
    count = np.maximum(np.bincount(run, minlength=groups), 1)
    turn = np.bincount(run, gated.turn[candidate], minlength=groups) / count
    sigma = np.bincount(run, gated.turn_sigma[candidate], minlength=groups) / count
    return np.asarray(np.abs(turn) <= MEAN_TURN + TURN_SIGMA * sigma)


def _slopes(
    scene: Scene, gated: Gated, chains: ChainOrder, of_point: IntArray, label: IntArray, groups: int
) -> tuple[FloatArray, FloatArray]:
    """Change of the distance along a run, and its standard deviation, (r,) each."""
    order = chains.order
    step = np.linalg.norm(np.diff(scene.xy[order], axis=0, prepend=scene.xy[order[:1]]), axis=1)
    along = np.zeros(len(scene.xy))
    along[order] = np.cumsum(np.where(chains.position == 0, 0.0, step))
    rows = np.flatnonzero(of_point >= 0)
    run, candidate = of_point[rows], label[rows]

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(run, values, minlength=groups) / np.maximum(count, 1.0))

    count = np.bincount(run, minlength=groups).astype(float)
    s = along[rows] - mean(along[rows])[run]
    d = gated.across[candidate] - mean(gated.across[candidate])[run]
    moment = np.maximum(mean(s * s), 1e-300)
    extent = np.sqrt(12.0 * moment)
    slope = np.where(count > 2, mean(s * d) / moment, 0.0)
    noise = mean(gated.noise[candidate]) / np.maximum(EFFECTIVE * count, 1.0)
    common = mean(gated.common[candidate]) / np.maximum(extent, 1e-12) ** 2
    return slope, np.sqrt(noise / moment + common)
