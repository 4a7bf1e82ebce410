"""Labels of one round: gate, chains, runs, exclusion, in order; and the reason of every point without one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from splinebba_cli.core.matching.known_curves.chain_directions import ChainOrder, Traced
from splinebba_cli.core.matching.known_curves.chain_labels import label_chains
from splinebba_cli.core.matching.known_curves.chance_hits import likely_by_chance
from splinebba_cli.core.matching.known_curves.exclusion import taken_points
from splinebba_cli.core.matching.known_curves.gates import Gated, gate_candidates
from splinebba_cli.core.matching.known_curves.runs import find_runs
from splinebba_cli.core.matching.known_curves.uncertainty import Uncertainty
from splinebba_cli.core.matching.matches import Matches, Reason
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

SHARP = 0.3  # common variance over that of the noise, below which distances are distributed like noise


@dataclass(frozen=True)
class LabelRound:
    """Labels of all unlabelled points, and how wide the gate was."""

    matches: Matches
    gate: FloatArray  # (n,) mm, half width at the label; NaN without
    common: FloatArray  # (n,) share of the predicted variance that is common to neighbours, over that of the noise


def label_points(
    scene: Scene, traced: Traced, uncertainty: Uncertainty, settings: MatchSettings, usable: BoolArray,
    curves: BoolArray,
) -> LabelRound:  # fmt: skip
    """Curves of all unlabelled points at the present state.

    Parameters
    ----------
    usable : (n,) points that may have a curve: not excluded, in an image with an orientation
    curves : (nc,) curves that may be taken
    """
    chains, tolerance = traced.order, settings.direction_tolerance_rad
    gated = gate_candidates(scene, uncertainty, traced.directions, settings.alpha, tolerance)
    point = gated.candidates.point
    allowed = gated.inside & gated.agrees & usable[point] & curves[gated.candidates.curve]
    none_cost = float(chdtri(1, settings.alpha))
    label = label_chains(scene, gated, chains, allowed, none_cost, tolerance)
    runs = find_runs(scene, gated, chains, label, settings.alpha)
    taken = taken_points(gated, runs, label, scene.curves.first, scene.curves.last)
    if taken.any():
        lost = np.zeros(len(point), dtype=bool)
        lost[label[taken]] = True
        again = chains.with_some(taken)
        second = label_chains(scene, gated, again, allowed & ~lost, none_cost, tolerance)
        label[again.order] = second[again.order]
        taken &= label < 0
        runs = find_runs(scene, gated, chains, label, settings.alpha)
    of_point = runs.of_point
    has = of_point >= 0
    fits, ambiguous = has.copy(), np.zeros(len(has), dtype=bool)
    fits[has], ambiguous[has] = runs.fits[of_point[has]], runs.ambiguous[of_point[has]]
    by_chance = _by_chance(gated, chains, np.where(fits & ~ambiguous, label, -1), none_cost)
    good = fits & ~ambiguous & ~by_chance
    reason = _reasons(gated, chains, usable, curves)
    reason[has & ~fits] = np.where(_alone(chains, len(has))[has & ~fits], Reason.FAR, Reason.CHAIN)
    reason[fits & ambiguous] = Reason.AMBIGUOUS
    reason[taken & ~good] = Reason.TAKEN
    reason[by_chance] = Reason.FAR
    reason[good] = Reason.MATCHED
    chosen = np.where(good, label, -1)
    return _as_round(gated, chosen, reason, none_cost)


def _by_chance(gated: Gated, chains: ChainOrder, label: IntArray, limit: float) -> BoolArray:
    """Single points that lie near their curve by chance, (n,), where errors of orientations do not blur distances."""
    found = np.zeros(len(label), dtype=bool)
    points = np.flatnonzero((label >= 0) & _alone(chains, len(label)))
    own = label[points]
    if len(points) and np.median(gated.common[own] / gated.noise[own]) < SHARP:
        found[points] = likely_by_chance(np.sqrt(gated.square[own]), float(np.sqrt(limit)))
    return found


def _as_round(gated: Gated, chosen: IntArray, reason: IntArray, limit: float) -> LabelRound:
    """Matches with the distances of the best and the next curve."""
    count = len(chosen)
    near = gated.candidates
    curve, location = np.full(count, -1), np.full(count, np.nan)
    gate, common = np.full(count, np.nan), np.zeros(count)
    rows = np.flatnonzero(chosen >= 0)
    own = chosen[rows]
    curve[rows], location[rows] = near.curve[own], near.location[own]
    variance = gated.noise[own] + gated.common[own]
    gate[rows], common[rows] = np.sqrt(limit * variance), gated.common[own] / gated.noise[own]
    best, second = _two_nearest(gated, count)
    distance = best.copy()
    distance[rows] = np.sqrt(gated.square[own])
    other = np.where(np.isclose(distance, best, rtol=1e-9), second, best)
    return LabelRound(Matches(curve, location, distance, other, reason), gate, common)


def _two_nearest(gated: Gated, count: int) -> tuple[FloatArray, FloatArray]:
    """Distances over sigma to the nearest curve and to the next one, (n,) each; inf where there is none."""
    point, curve = gated.candidates.point, gated.candidates.curve
    best, second = np.full(count, np.inf), np.full(count, np.inf)
    if not len(point):
        return best, second
    order = np.lexsort((gated.square, point))
    first = order[np.diff(point[order], prepend=-1) != 0]
    best[point[first]] = np.sqrt(gated.square[first])
    nearest = np.full(count, -1)
    nearest[point[first]] = curve[first]
    others = order[curve[order] != nearest[point[order]]]
    next_one = others[np.diff(point[others], prepend=-1) != 0]
    second[point[next_one]] = np.sqrt(gated.square[next_one])
    return best, second


def _reasons(gated: Gated, chains: ChainOrder, usable: BoolArray, curves: BoolArray) -> IntArray:
    """Why a point has no candidate at all, or has them and its chain goes elsewhere, (n,)."""
    count = len(usable)
    possible = gated.inside & curves[gated.candidates.curve]
    near = np.bincount(gated.candidates.point[possible], minlength=count) > 0
    agrees = np.bincount(gated.candidates.point[possible & gated.agrees], minlength=count) > 0
    reason = np.full(count, int(Reason.FAR))
    reason[near & ~agrees] = Reason.DIRECTION
    reason[agrees & ~_alone(chains, count)] = Reason.CHAIN
    return reason


def _alone(chains: ChainOrder, count: int) -> BoolArray:
    """Single points, (n,)."""
    alone = np.zeros(count, dtype=bool)
    alone[chains.order] = chains.end - chains.begin == 1
    return alone
