"""Curves from coarse to fine with the orientations held: the stage between points and the joint adjustment.

Every curve starts with knots a few spacings apart, is adjusted, gets knots twice as dense, and so on down to the
wanted spacing (theory, section 6: coarse knots before fine ones).  Smoothing helps a start that wobbles and ruins
one with a hairpin, so several ways are gone and every curve keeps the best of its own.  At the end knots are
re-spaced on the adjusted curve as long as that helps, and inserted where residuals ask for them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from splinebba_cli.core.approximation.knot_insertion import with_inserted_knots
from splinebba_cli.core.approximation.knot_removal import with_removed_knots
from splinebba_cli.core.approximation.knot_spacing import (
    present_curve,
    respaceable,
    respaced_network,
    restart,
)
from splinebba_cli.core.estimation.curve_folding import folded_segments
from splinebba_cli.core.estimation.curve_stage import curves_alone, solve_curves
from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.estimation.stretches import curve_costs
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.observations.coefficient_rows import (
    knot_distance,
)
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import Prepared, State

WAYS = (
    (False, 1.0),
    (False, 4.0),
    (True, 4.0),
    (False, 2.0),
    (True, 2.0),
)  # smooth, first spacing in wanted ones
MORE_WAYS = (
    (True, 8.0),
    (True, 1.0),
    (False, 3.0),
    (True, 3.0),
)  # for curves that fit much worse than the others
MUCH_WORSE = 2.0  # times the usual mean square of the residuals
POLISHES = 6
INSERTIONS = 8
ITERATIONS = 25
KNOT_PRICE = 0.5  # of v'Pv that a knot must save: the wanted spacing is the user's
FOLD_PRICE = 1.2
CALMING = (1.25, 0.8, 0.6)  # times the knot distance of a curve that keeps an adjustment from settling


@dataclass(frozen=True)
class Candidate:
    """All curves in one state, with the price of each."""

    prepared: Prepared
    state: State
    price: FloatArray  # (nc,)


def refine_curves(
    prepared: Prepared, state: State, observer: Observer | None, *, spaced: bool = False
) -> tuple[Prepared, State]:
    """Curves adjusted with orientations and points held; knots as the settings of the network allow.

    Parameters
    ----------
    spaced : whether the knots already follow the settings, so that a curve may also stay as it is
    """
    policy = prepared.network.settings.knots
    state = search_locations(prepared, state)
    if policy.spacing_m is None:
        best = _adjusted(prepared, state, observer)
    else:
        target = np.array([policy.spacing_m if respaceable(c) else np.nan for c in prepared.network.curves])
        candidates = [_adjusted(prepared, state, observer)] if spaced else []
        candidates += [_coarse_to_fine(prepared, state, target, *way, observer) for way in WAYS]
        best = _rescued(reduce(_better, candidates), prepared, state, target, observer)
        for _ in range(POLISHES):
            polished = _adjusted(*respaced_network(best.prepared, best.state, target, smooth=False), observer)
            before, best = best, _better(best, polished)
            if best.price.sum() > 0.999 * before.price.sum():
                break
    if policy.insert:
        best = _insert(best, observer)
    if policy.drop:
        best = _drop(best, observer)
    return best.prepared, best.state


def calmed(
    prepared: Prepared, state: State, restless: tuple[int, ...], observer: Observer | None
) -> tuple[Prepared, State]:
    """Network and state with other knots in the curves that kept an adjustment from settling.

    Somewhat fewer or more of them, whichever fits best: hairpins ask for more, wobbling stretches for fewer.
    """
    state = search_locations(prepared, state)
    candidates = []
    for factor in CALMING:
        spacing = np.full(len(prepared.network.curves), np.nan)
        for k in restless:
            spacing[k] = factor * knot_distance(prepared.network.curves[k])
        candidates.append(_adjusted(*respaced_network(prepared, state, spacing, smooth=False), observer))
    best = _drop(reduce(_better, candidates), observer)
    return best.prepared, best.state


def _coarse_to_fine(
    prepared: Prepared,
    state: State,
    target: FloatArray,
    smooth: bool,
    factor: float,
    observer: Observer | None,
) -> Candidate:
    while True:
        candidate = _adjusted(*respaced_network(prepared, state, factor * target, smooth=smooth), observer)
        if factor <= 1.0:
            return candidate
        prepared, state = candidate.prepared, candidate.state
        smooth, factor = False, max(0.5 * factor, 1.0)


def _rescued(
    best: Candidate, prepared: Prepared, state: State, target: FloatArray, observer: Observer | None
) -> Candidate:
    """More ways, from the start and from the present shape, for curves that fit much worse than the others."""
    curve = prepared.network.curve_observations.curve
    number = np.bincount(curve, minlength=len(best.price))
    mean_square = best.price / np.maximum(number, 1)
    poor = (mean_square > MUCH_WORSE * np.median(mean_square)) & np.isfinite(target)
    if not poor.any():
        return best
    own = np.where(poor, target, np.nan)
    for way in MORE_WAYS:
        for begin in ((prepared, state), (best.prepared, best.state)):
            other = _coarse_to_fine(*begin, own, *way, observer)
            best = _better(best, replace(other, price=np.where(poor, other.price, np.inf)))
    return best


def _insert(best: Candidate, observer: Observer | None) -> Candidate:
    """Insert knots where residuals along a curve are systematic, as long as that pays."""
    for _ in range(INSERTIONS):
        denser = with_inserted_knots(best.prepared, best.state)
        if denser is None:
            break
        before, best = best, _better(best, _adjusted(*denser, observer))
        if best.price.sum() > 0.999 * before.price.sum():
            break
    return best


def _drop(best: Candidate, observer: Observer | None) -> Candidate:
    """Remove knots that nothing supports."""
    for _ in range(INSERTIONS):
        fewer = with_removed_knots(best.prepared, best.state)
        if fewer is None:
            break
        reduced = _adjusted(*fewer, observer)
        if not np.isfinite(reduced.price).all():
            break
        best = reduced
    return best


def _adjusted(prepared: Prepared, state: State, observer: Observer | None) -> Candidate:
    """All curves adjusted with orientations and points held, and priced."""
    assembler = curves_alone(prepared)
    knots = np.diff(prepared.curves.coefficient_start)
    try:
        state = solve_curves(assembler, state, max_iterations=ITERATIONS, observer=observer)
        at = assembler.linearize(state, held_locations(prepared, state.location))
    except FloatingPointError:  # a shape that reaches behind a camera is none
        return Candidate(prepared, state, np.full(len(knots), np.inf))
    folded = folded_segments(prepared, state.coefficients) > 0
    cost = curve_costs(assembler, at) * np.where(folded, FOLD_PRICE, 1.0)
    return Candidate(prepared, state, cost + KNOT_PRICE * knots)


def _better(first: Candidate, second: Candidate) -> Candidate:
    """The cheaper of two for every curve."""
    take = second.price < first.price
    if not take.any():
        return first
    curves = tuple(
        present_curve(side.prepared, k, side.state.coefficients[_rows(side.prepared, k)])
        for k, side in enumerate(second if chosen else first for chosen in take)
    )
    prepared, state = restart(first.prepared.network, curves, first.state)
    measured: BoolArray = take[prepared.network.curve_observations.curve]
    state = State(
        state.rotation,
        state.position,
        state.coefficients,
        state.xyz,
        np.where(measured, second.state.location, first.state.location),
    )
    return Candidate(prepared, state, np.where(take, second.price, first.price))


def _rows(prepared: Prepared, k: int) -> slice:
    start = prepared.curves.coefficient_start
    return slice(int(start[k]), int(start[k + 1]))
