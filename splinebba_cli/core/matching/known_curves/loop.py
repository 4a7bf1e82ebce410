"""Matching against curves whose shape is known or given approximately: ICP with the adjustment in the loop.

    given measurements, priors       -> orientations and their dispersion
    images aligned one by one        -> where the prior leaves several curves to a point (align_images.py)
    repeat
        candidates inside the gate, chains, runs, exclusion     -> labels (label_round.py)
        adjustment with these labels                            -> state, dispersion: the gate of the next round
    until no label changes

first with the curves whose shape is known, then with all that have one.  Curves of approximate shape are adjusted as
soon as two images see them.
"""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from splinebba_cli.core.estimation.gauss_markov import Observer
from splinebba_cli.core.matching.known_curves.align_images import aligned
from splinebba_cli.core.matching.known_curves.determined_images import determined_by_labels
from splinebba_cli.core.matching.known_curves.finishing import Known, finished
from splinebba_cli.core.matching.known_curves.label_round import LabelRound
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.known_curves.orientation_prior import with_prior
from splinebba_cli.core.matching.known_curves.round_adjustment import Round
from splinebba_cli.core.matching.known_curves.shape_gates import with_shape_gates
from splinebba_cli.core.matching.matches import GateStep
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import BoolArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State

_log = logging.getLogger(__name__)

ITERATIONS = 12  # of an adjustment inside the loop
POINTS = (
    1000  # of an image on held curves that take part in the adjustments of rounds: orientations need no more
)
CAUTION = 4.0  # times the variances of the adjustment, while many labels change
STEADY = 0.02  # share of points that change: below it the variances count as they are
ROBUST_ROUNDS = 2  # at least, with weights from residuals
NONE = 1e-3  # share of points whose change ends a stage
NEARLY_NONE = 5e-3  # share of points whose change, three times in a row, ends a stage


def match_known_curves(
    network: Network, settings: MatchSettings, *, observer: Observer | None = None
) -> Known:
    """Labels of the unlabelled points of a network on the curves that it has, and better orientations.

    Parameters
    ----------
    network : images without an orientation stay out
    observer : called after every iteration of the adjustments inside
    """
    context = LoopContext.of(network, settings, observer)
    progress = _with_given(context, context.begin())
    history: list[GateStep] = []
    problems: tuple[Problem, ...] = ()
    curves, none = context.start.known, np.zeros(len(network.images.ids), dtype=bool)
    if context.start.shaped.any() and len(network.unlabelled):
        context, progress, problems = aligned(context, progress, ~none)
    if curves.any():
        progress = _stage(context, progress, "known curves", curves, none, history)
        context, progress, problems = _held_by_neighbours(context, progress, problems, history)
    if (context.start.shaped & ~curves).any():
        settled = determined_by_labels(context, progress)
        curves = context.start.shaped
        progress = with_shape_gates(context, progress)
        progress = _stage(context, progress, "all curves", curves, settled, history)
    return finished(context, progress, curves, tuple(history), problems)


def _held_by_neighbours(
    context: LoopContext, progress: Progress, problems: tuple[Problem, ...], history: list[GateStep]
) -> tuple[LoopContext, Progress, tuple[Problem, ...]]:
    """Images that were not clear alone, looked at again with what the adjustment now knows of them."""
    network = context.start.network
    if not context.blocked.any() or not len(network.point_observations) + len(network.curve_observations):
        return context, progress, problems
    before = context.blocked
    context, progress, problems = aligned(context, progress, before)
    if (before & ~context.blocked).any():
        none = np.zeros(len(before), dtype=bool)
        progress = _stage(context, progress, "known curves, again", context.start.known, none, history)
    return context, progress, problems


def _with_given(context: LoopContext, progress: Progress) -> Progress:
    """Orientations from what the network brings along."""
    network = context.start.network
    if not len(network.point_observations) + len(network.curve_observations):
        return progress
    _, kept = context.taken(progress.labels.curve, progress.labels.location, context.start.known)
    found = context.adjust(progress, kept, network, ITERATIONS, robust=False)
    return progress if found is None else progress.after(found, 1.0)


def _stage(
    context: LoopContext, progress: Progress, name: str, curves: BoolArray, held: BoolArray,
    history: list[GateStep],
) -> Progress:  # fmt: skip
    """Rounds of labels and adjustments with some of the curves until nothing changes.

    Parameters
    ----------
    held : (m,) images whose orientation is held as long as many labels change
    """
    still = 0
    holding = with_prior(context.start.network, context.start.prior, held | ~context.start.prior.known)
    for number in range(1, context.settings.rounds + 1):
        found = context.label(progress, curves)
        labels, kept = context.taken(found.matches.curve, found.matches.location, curves)
        changed = int((labels.curve != progress.labels.curve).sum())
        share = changed / max(len(labels.curve), 1)
        progress = replace(progress, labels=labels)
        solved = None
        if len(labels.rows):
            moving = number > 1 and share <= STEADY
            network = context.start.network if moving or not held.any() else holding
            part = replace(progress, labels=context.thinned(labels, POINTS))
            robust = number <= ROBUST_ROUNDS or share > STEADY
            solved = context.adjust(part, kept, network, ITERATIONS, robust=robust)
        history.append(_step(context, name, number, found, changed, solved, progress.state))
        if solved is None:
            break
        progress = progress.after(solved, CAUTION if share > STEADY else 1.0)
        still = still + 1 if share <= NEARLY_NONE else 0
        if number > 1 and (share <= NONE or still > 2):
            break
    return progress


def _step(
    context: LoopContext, stage: str, number: int, found: LabelRound, changed: int, solved: Round | None,
    before: State,
) -> GateStep:  # fmt: skip
    """What one round did."""
    pixels = [camera.pixel_size_mm for camera in context.network.cameras if camera.pixel_size_mm is not None]
    gate = found.gate[np.isfinite(found.gate)]
    shift, turn = _moved(before, before if solved is None else solved.state)
    step = GateStep(
        stage=stage,
        number=number,
        gate_px=float(np.median(gate)) / (float(np.mean(pixels)) if pixels else 1.0) if len(gate) else np.nan,
        matched=int((found.matches.curve >= 0).sum()),
        changed=changed,
        sigma0=np.nan if solved is None else solved.fit.sigma0,
        position_step_m=shift,
        angle_step_rad=turn,
    )
    _log.info(
        "%s, round %d: %d of %d points matched, %d changed, gate %.2f px",
        stage, number, step.matched, len(context.usable), changed, step.gate_px,
    )  # fmt: skip
    return step


def _moved(old: State, new: State) -> tuple[float, float]:
    """Largest change of a perspective centre (m) and of an angle (rad)."""
    shift = float(np.linalg.norm(new.position - old.position, axis=1).max(initial=0.0))
    turn = np.einsum("mji,mjk->mik", old.rotation, new.rotation)
    skew = np.stack(
        [turn[:, 2, 1] - turn[:, 1, 2], turn[:, 0, 2] - turn[:, 2, 0], turn[:, 1, 0] - turn[:, 0, 1]]
    )
    return shift, float(0.5 * np.linalg.norm(skew, axis=0).max(initial=0.0))
