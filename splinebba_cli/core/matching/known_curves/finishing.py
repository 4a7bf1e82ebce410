"""The end of the loop: which images are determined, gross errors out, what is handed back.

An assumed prior is no measurement: it leaves the last adjustment, but for images whose matched curves say less about
some direction than the prior does.  Those keep the orientation that was given.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from splinebba_cli.core.matching.known_curves.determined_images import undetermined_images
from splinebba_cli.core.matching.known_curves.label_round import LabelRound
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.known_curves.misfit import misfits
from splinebba_cli.core.matching.known_curves.orientation_prior import without_assumed
from splinebba_cli.core.matching.known_curves.round_adjustment import Round
from splinebba_cli.core.matching.known_curves.round_network import Labels
from splinebba_cli.core.matching.matches import GateStep, Matches, Reason
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State

ITERATIONS = 60
GROSS_ROUNDS = 5
FEW = 1e-3  # share of labelled points: so many gross errors more change nothing
LEAST = 0.1  # redundancy number of a point with which its residual still tells something


_NOT_TOGETHER = Problem(
    "SBB583",
    "warning",
    "without the assumed standard deviations of approximate orientations an adjustment with the matched points has no "
    "solution; orientations stay as given",
    "matching",
    "adjust the matched project: the adjustment says what is not determined",
)


@dataclass(frozen=True)
class Known:
    """What matching against given curves found."""

    state: State  # of all curves of the network; locations belong to nothing
    matches: Matches
    oriented: BoolArray  # (m,) images whose orientation the matched curves improved
    dispersion: FloatArray  # (m, 6, 6) of theta, X0; NaN where an orientation is not estimated
    improved_curves: BoolArray  # (nc,) whose shape the labels have improved
    history: tuple[GateStep, ...]
    problems: tuple[Problem, ...]


def finished(
    context: LoopContext,
    progress: Progress,
    curves: BoolArray,
    history: tuple[GateStep, ...],
    problems: tuple[Problem, ...],
) -> Known:
    """Last labels, adjustment and verdicts.

    Parameters
    ----------
    curves : (nc,) of the last stage
    """
    start = context.start
    weak, named = undetermined_images(context, progress)
    network = without_assumed(start.network, start.prior, weak | _without_measurements(context, progress))
    gross = np.zeros(len(context.usable), dtype=bool)
    found, solved, kept = None, None, start.known
    curve, location = progress.labels.curve, progress.labels.location
    for _ in range(GROSS_ROUNDS):
        labels, kept = context.taken(np.where(gross, -1, curve), location, curves)
        progress = replace(progress, labels=labels)
        if not len(labels.rows):
            break
        solved = context.adjust(progress, kept, network, ITERATIONS, robust=False)
        if solved is None and network is not start.network:  # not determined without the assumed priors
            weak, network, named = start.prior.known.copy(), start.network, (*named, _NOT_TOGETHER)
            solved = context.adjust(progress, kept, network, ITERATIONS, robust=False)
        if solved is None:
            break
        progress = progress.after(solved, 1.0)
        found = context.label(progress, curves)
        curve, location = found.matches.curve, found.matches.location
        beyond = _gross(context, found, labels, start.held)
        few = (beyond & ~gross).sum() <= FEW * len(labels.rows)
        gross |= beyond
        if few:
            break
    if found is None:
        found = context.label(progress, curves)
    elif solved is not None:
        handed_on, last = context.taken(np.where(gross, -1, curve), location, curves)
        again = _adjusted_again(context, progress, handed_on, last, network)
        if again is not None:
            solved, kept, progress = again, last, replace(progress, labels=handed_on).after(again, 1.0)
    seen = np.bincount(context.network.unlabelled.image[progress.labels.rows], minlength=len(weak))
    oriented = (seen > 0) & ~weak & start.prior.known & (solved is not None)
    return Known(
        state=_state(context, progress.state, weak | (seen == 0)),
        matches=_matches(context, found, gross, curves),
        oriented=oriented,
        dispersion=_dispersion(progress, solved, oriented),
        improved_curves=kept & ~start.known & (solved is not None),
        history=history,
        problems=(
            *problems,
            *named,
            *_empty_images(context, seen),
            *_unsolved(progress, solved),
            *misfits(context, progress, solved),
        ),
    )


def _adjusted_again(
    context: LoopContext, progress: Progress, labels: Labels, kept: BoolArray, network: Network
) -> Round | None:
    """The adjustment with the very labels that are handed on; None where the last one had them."""
    if not len(labels.rows) or (labels.curve == progress.labels.curve).all():
        return None
    return context.adjust(replace(progress, labels=labels), kept, network, ITERATIONS, robust=False)


def _without_measurements(context: LoopContext, progress: Progress) -> BoolArray:
    """Images (m,) that nothing but their prior holds."""
    network, points = context.start.network, context.network.unlabelled
    image: IntArray = np.concatenate(
        [
            network.point_observations.image,
            network.curve_observations.image,
            points.image[progress.labels.rows],
        ]
    )
    return np.asarray(np.bincount(image, minlength=len(context.blocked)) == 0)


def _empty_images(context: LoopContext, seen: IntArray) -> list[Problem]:
    """Warnings about images none of whose points follows a curve; what others have labelled speaks for an image."""
    ids, image = context.network.images.ids, context.network.unlabelled.image[context.usable]
    labelled = np.bincount(context.start.network.curve_observations.image, minlength=len(ids)) > 0
    has_points = (np.bincount(image, minlength=len(ids)) > 0) & ~context.blocked & ~labelled
    return [
        Problem(
            "SBB582",
            "warning",
            f"image `{ids[k]}`: none of its {int((image == k).sum())} unlabelled points follows a curve",
            f"image `{ids[k]}`",
            "look at its approximate orientation, and how far it may be off (`position_sigma_m`, `angle_sigma_deg`); "
            "does the project have curves where it looks?",
        )
        for k in np.flatnonzero(has_points & (seen == 0))
    ]


def _unsolved(progress: Progress, solved: Round | None) -> list[Problem]:
    """A warning where labels allow no adjustment."""
    if solved is not None or not len(progress.labels.rows):
        return []
    return [
        Problem(
            "SBB583",
            "warning",
            f"{len(progress.labels.rows)} points are matched, but an adjustment with them has no solution; "
            "orientations stay as they were before",
            "matching",
            "adjust the matched project: the adjustment says what is not determined",
        )
    ]


def _gross(context: LoopContext, found: LabelRound, labels: Labels, held: BoolArray) -> BoolArray:
    """Labelled points whose standardised residual is no chance, (n,).

    A point that took part is nearer to its curve than one that did not: its residual has the variance of its noise
    less that of the projected curve, not their sum.  Of curves that are adjusted only an upper bound of the latter is
    at hand (their correlation with the orientations is neglected), so that the variance of the noise counts.

    Parameters
    ----------
    held : (nc,) curves that are not adjusted
    """
    curve = found.matches.curve
    took_part = (labels.curve >= 0) & (labels.curve == curve)
    on_held = held[np.maximum(curve, 0)]
    total, own = 1.0 + found.common, np.where(on_held, np.maximum(1.0 - found.common, LEAST), 1.0)
    square = found.matches.distance**2 * np.where(took_part, total / own, 1.0)
    return np.asarray((found.matches.curve >= 0) & (square > chdtri(1, context.settings.alpha)))


def _matches(context: LoopContext, found: LabelRound, gross: BoolArray, curves: BoolArray) -> Matches:
    """Matches with gross errors and points that take no part named.

    Parameters
    ----------
    curves : (nc,) of the last stage
    """
    matches = found.matches
    reason: IntArray = matches.reason.copy()
    sound, _ = context.taken(np.where(gross, -1, matches.curve), matches.location, curves)
    reason[(matches.curve >= 0) & (sound.curve < 0)] = Reason.ONE_IMAGE
    out = gross & (matches.curve >= 0)
    reason[out] = Reason.GROSS
    reason[~context.start.prior.known[context.network.unlabelled.image]] = Reason.NOT_ORIENTED
    reason[context.blocked[context.network.unlabelled.image]] = Reason.AMBIGUOUS
    reason[context.excluded] = Reason.EXCLUDED
    none = reason != Reason.MATCHED
    return replace(
        matches,
        curve=np.where(none, -1, matches.curve),
        location=np.where(none, np.nan, matches.location),
        reason=reason,
    )


def _state(context: LoopContext, state: State, given: BoolArray) -> State:
    """The state, orientations of some images as they were given."""
    prior = context.start.prior
    keep = given & prior.known
    return replace(
        state,
        rotation=np.where(keep[:, None, None], prior.rotation, state.rotation),
        position=np.where(keep[:, None], prior.position, state.position),
    )


def _dispersion(progress: Progress, solved: Round | None, oriented: BoolArray) -> FloatArray:
    """Dispersions of orientations of the last adjustment, times its variance of unit weight."""
    found = np.full((len(oriented), 6, 6), np.nan)
    if solved is not None:
        factor = solved.fit.variance if solved.fit.redundancy else 1.0
        found[oriented] = factor * progress.uncertainty.eop[oriented]
    return found
