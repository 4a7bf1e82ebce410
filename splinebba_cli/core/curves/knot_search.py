"""Few knots for a given largest distance: insert where the fit is worst, then remove, merge and move.

1. Insertion (Lee 2008, 2.3.1): every segment with a point beyond the threshold is divided where half of the
   squared distances lies on either side, until no point is beyond it.
2. Groups of neighbouring knots are replaced by one fewer, evenly spaced within the group.
3. Knots move (:mod:`.knot_relaxation`), which makes room for step 2; both are repeated until the number of knots
   settles.
4. Single knots are removed while those around each of them move.

The influence of a knot fades by a factor of about 0.27 from knot to knot.  So a change of one group is tried together
with changes of other groups far from it, in one fit; each is judged by the points around it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.knot_fit import KnotFit, first_knots, fitted, refitted
from splinebba_cli.core.curves.knot_relaxation import holds_points, relaxed
from splinebba_cli.core.curves.polyline import Polyline
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

REACH = 4  # knots on either side that a change is judged by
GROUPS = (1, 2, 3, 4, 6)  # neighbouring knots that are replaced by one fewer
MOVED = 3  # knots on either side that move when one is removed
STEPS = 3  # Gauss–Newton steps of a movement
ROUNDS = 8  # at most
ROUNDS_WITH_ALL = 1  # after a search with some of the points
WORTH_A_ROUND = 0.05  # share of the knots that a round must save for another one
SEARCHED_POINTS = 2500  # about so many points take part in the search


@dataclass(frozen=True)
class Change:
    """Knots `first` … `first + gone - 1` make way for others."""

    first: int
    gone: int
    new: FloatArray


def few_knots(polyline: Polyline, threshold: float) -> KnotFit:
    """The fit with few knots from which no point is farther than the threshold.

    Long polylines are searched with some of their points; all points have the last word.
    """
    step = len(polyline.points) // SEARCHED_POINTS
    if step < 2:
        inserted = with_inserted_knots(polyline, first_knots(polyline), threshold)
        return with_fewer_knots(polyline, inserted, threshold, ROUNDS)
    few = few_knots(polyline.thinned(step), threshold)
    inserted = with_inserted_knots(polyline, few.knots, threshold)
    return with_fewer_knots(polyline, inserted, threshold, ROUNDS_WITH_ALL)


def with_inserted_knots(polyline: Polyline, knots: FloatArray, threshold: float) -> KnotFit:
    """Insert knots until no point is farther than the threshold; at the latest with a knot at every point."""
    every = np.append(polyline.parameters, polyline.end) if polyline.closed else polyline.parameters
    fit = fitted(polyline, knots, threshold)
    while fit.largest > threshold and not np.isin(every, fit.knots).all():
        fit = fitted(polyline, _divided(polyline, fit, every, threshold), threshold)
    return fit


def _divided(polyline: Polyline, fit: KnotFit, every: FloatArray, threshold: float) -> FloatArray:
    """Knots with new ones, at parameters of points, where the fit is worst."""
    segments = len(fit.knots) - 1
    segment = np.clip(np.searchsorted(fit.knots, polyline.parameters, side="right") - 1, 0, segments - 1)
    worst = np.zeros(segments)
    np.maximum.at(worst, segment, fit.distance)
    new = []
    for s in np.flatnonzero(worst > threshold):
        inside = np.flatnonzero((segment == s) & (polyline.parameters > fit.knots[s]))
        inside = inside[polyline.parameters[inside] < fit.knots[s + 1]]
        if len(inside):
            square = np.cumsum(fit.distance[inside] ** 2)
            new.append(polyline.parameters[inside[np.searchsorted(square, 0.5 * square[-1])]])
    if not new:  # segments without inner points: give their neighbours a knot, in the end all points
        free = np.setdiff1d(every, fit.knots)
        bad = polyline.parameters[fit.distance > threshold]
        new = [free[np.argmin(np.abs(free - u))] for u in bad]
    return np.unique(np.concatenate([fit.knots, new]))


def with_fewer_knots(polyline: Polyline, fit: KnotFit, threshold: float, rounds: int) -> KnotFit:
    """Remove, merge and move knots as long as no point gets farther than the threshold."""
    if fit.largest > threshold:
        return fit
    for number in range(rounds):
        count = len(fit.knots)
        if number > 0:
            fit = relaxed(polyline, fit, threshold, _movable(polyline, fit.knots), STEPS)
        for size in GROUPS:
            fit = _pass_over(polyline, fit, threshold, size)
        if number > 0 and count - len(fit.knots) < WORTH_A_ROUND * count:
            fit = _pass_with_moves(polyline, fit, threshold)
            if count - len(fit.knots) < WORTH_A_ROUND * count:
                break
    return fit


def _pass_with_moves(polyline: Polyline, fit: KnotFit, threshold: float) -> KnotFit:
    """Remove single knots and move those around each, wherever the threshold then is kept."""
    for phase in range(1 + 2 * REACH):
        changes = _changes(polyline, fit.knots, 1, phase)
        if not changes:
            continue
        trial = refitted(polyline, fit, _changed(fit.knots, changes), threshold, reweightings=0)
        first = np.array([max(1, change.first - MOVED) for change in changes])
        last = np.array([min(len(fit.knots) - 2, change.first + MOVED) for change in changes])
        start, stop = first - np.arange(len(changes)), last - np.arange(len(changes))  # in the trial's knots
        free = np.zeros(len(trial.knots), dtype=bool)
        for a, b in zip(start, stop, strict=True):
            free[a:b] = True
        trial = relaxed(polyline, trial, threshold, free & _movable(polyline, trial.knots), STEPS)
        moved = [
            Change(int(i), int(j - i + 1), trial.knots[a:b])
            for i, j, a, b in zip(first, last, start, stop, strict=True)
        ]
        fit = _accepted(polyline, fit, moved, threshold)
    return fit


def _movable(polyline: Polyline, knots: FloatArray) -> BoolArray:
    """Knots that are neither ends nor corners, (k,)."""
    fixed = np.isin(knots, polyline.corners)
    fixed[[0, -1]] = True
    return ~fixed


def _changes(polyline: Polyline, knots: FloatArray, size: int, phase: int) -> list[Change]:
    """Groups of `size` knots far from each other, with the fewer knots that may replace them."""
    movable = _movable(polyline, knots)
    out = []
    for first in range(1 + phase, len(knots) - size, size + 2 * REACH):
        if movable[first : first + size].all():
            around = knots[first - 1 : first + size + 1]
            new = np.interp(np.linspace(0, size + 1, size + 1), np.arange(size + 2), around)[1:-1]
            if holds_points(polyline, np.concatenate([around[:1], new, around[-1:]])).all():
                out.append(Change(first, size, new))
    return out[: max(0, len(knots) - (4 if polyline.closed else 2))]


def _pass_over(polyline: Polyline, fit: KnotFit, threshold: float, size: int) -> KnotFit:
    """Replace groups of `size` knots by one fewer wherever the threshold allows it."""
    for phase in range(size + 2 * REACH):
        fit = _accepted(polyline, fit, _changes(polyline, fit.knots, size, phase), threshold)
    return fit


def _accepted(polyline: Polyline, fit: KnotFit, changes: list[Change], threshold: float) -> KnotFit:
    """The fit with those changes that keep the threshold."""
    while changes:
        trial = refitted(polyline, fit, _changed(fit.knots, changes), threshold)
        if trial.largest <= threshold:
            return trial
        beyond = trial.distance > threshold
        bad = np.unique(_segment_of(fit.knots, polyline.parameters[beyond]))
        kept = [c for c in changes if not _near(c, bad, len(fit.knots) - 1, polyline.closed).any()]
        if len(kept) == len(changes):
            break
        changes = kept
    return fit


def _changed(knots: FloatArray, changes: list[Change]) -> FloatArray:
    gone = np.zeros(len(knots), dtype=bool)
    for change in changes:
        gone[change.first : change.first + change.gone] = True
    return np.sort(np.concatenate([knots[~gone], *(change.new for change in changes)]))


def _segment_of(knots: FloatArray, parameters: FloatArray) -> IntArray:
    return np.clip(np.searchsorted(knots, parameters, side="right") - 1, 0, len(knots) - 2)


def _near(change: Change, segment: IntArray, segments: int, closed: bool) -> BoolArray:
    """Which segments lie within the reach of a change."""
    first, last = change.first - 1, change.first + change.gone - 1  # segments of the group
    before, after = first - segment, segment - last
    if closed:
        before = np.where(before > segments // 2, before - segments, before)
        after = np.where(after > segments // 2, after - segments, after)
    return np.asarray((before <= REACH) & (after <= REACH))
