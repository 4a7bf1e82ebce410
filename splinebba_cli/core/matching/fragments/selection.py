"""Which stretches of runs become fragments: the best supported first, and no image point for two different edges.

Every run explains points of several chains: its own and those that it is linked to.  The run with most links is taken
first; of later ones only what points that are still free support is taken, with a few places more at either end so
that neighbours overlap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.explained_points import ExplainedPoints
from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.runs import Runs
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray

LEAST_PLACES = 4  # that a third image confirms
LEAST_PLACES_OF_TWO = 8  # of a fragment that only two images see
OVERLAP = 3  # places that a fragment shares with its neighbour
FILL = 3  # places without free support that are kept inside


@dataclass(frozen=True)
class Stretch:
    """Consecutive chain points of the reference image that become the places of a fragment."""

    first: int
    last: int  # one behind


def selected_stretches(
    chains: TracedChains, labels: LabelledPoints, runs: Runs, *, two_images: BoolArray
) -> list[Stretch]:
    """Stretches to make fragments of, best first.

    Parameters
    ----------
    two_images : (n,) points whose depth may rest on two images alone
    """
    links = np.bincount(labels.link_point, minlength=len(chains))
    worth = np.concatenate([[0], np.cumsum(np.where(links > 1, links, 0))])
    order = np.argsort(-(worth[runs.last] - worth[runs.first]), kind="stable")
    explained = ExplainedPoints(chains, labels)
    out = []
    for k in order:
        first, last = int(runs.first[k]), int(runs.last[k])
        support = explained.free_links(first, last)
        free = ~explained.taken[first:last]
        for a, b in _stretches(free & ((support > 0) | runs.bridged[first:last])):
            confirmed = support[a:b] > 1
            alone = two_images[first + a : first + b].all() and b - a >= LEAST_PLACES_OF_TWO
            if confirmed.sum() < LEAST_PLACES and not alone:
                continue
            if not alone:
                beside = _beside_confirmed(chains, labels, explained, first + a, confirmed)
                a, b = _held(beside, confirmed, a)
            stretch = Stretch(first + max(a - OVERLAP, 0), min(first + b + OVERLAP, last))
            out.append(stretch)
            explained.take(stretch.first, stretch.last)
    return out


def _stretches(ok: BoolArray) -> list[tuple[int, int]]:
    """Ranges of places that are right, with small gaps filled."""
    number = np.flatnonzero(ok)
    if not len(number):
        return []
    cut = np.flatnonzero(np.diff(number) > FILL + 1)
    first, last = np.concatenate([[0], cut + 1]), np.concatenate([cut, [len(number) - 1]])
    return list(zip(number[first].tolist(), (number[last] + 1).tolist(), strict=True))


def _held(beside: BoolArray, confirmed: BoolArray, offset: int) -> tuple[int, int]:
    """Range of a stretch without ends of two images that are longer than what three images confirm."""
    seen, sure = np.flatnonzero(beside), np.flatnonzero(confirmed)
    first = max(int(seen[0]), int(sure[0]) - len(sure))
    last = min(int(seen[-1]), int(sure[-1]) + len(sure))
    return offset + first, offset + last + 1


def _beside_confirmed(
    chains: TracedChains, labels: LabelledPoints, explained: ExplainedPoints, first: int, confirmed: BoolArray
) -> BoolArray:
    """Places that three images see, and those of two that stay on a chain of them.

    Parameters
    ----------
    first : chain point of the first place
    confirmed : (k,) places that three images see
    """
    rows = explained.links(first, first + len(confirmed))
    piece = chains.piece[labels.link_place[rows].astype(np.int64)]
    place = labels.link_point[rows] - first
    beside = np.bincount(place, np.isin(piece, piece[confirmed[place]]), minlength=len(confirmed)) > 0
    return np.asarray(confirmed | beside)
