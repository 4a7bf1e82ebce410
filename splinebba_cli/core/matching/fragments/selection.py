"""Which stretches of runs become fragments: the best supported first, and no image point for two different edges.

Every run explains points of several chains: its own and those that it is linked to.  The run with most links is taken
first; of later ones only what points that are still free support is taken, with a few places more at either end so
that neighbours overlap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.fragments.labelled_points import LabelledPoints
from splinebba_cli.core.matching.fragments.runs import Runs
from splinebba_cli.core.matching.fragments.traced_chains import TracedChains
from splinebba_cli.core.network import BoolArray, IntArray

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
    begin = np.searchsorted(labels.link_point, np.arange(len(chains) + 1))
    links = np.diff(begin)
    worth = np.concatenate([[0], np.cumsum(np.where(links > 1, links, 0))])
    order = np.argsort(-(worth[runs.last] - worth[runs.first]), kind="stable")
    taken = np.zeros(len(chains), dtype=bool)
    nearest = np.rint(labels.link_place).astype(np.int64)
    out = []
    for k in order:
        first, last = int(runs.first[k]), int(runs.last[k])
        rows = slice(begin[first], begin[last])
        free = ~taken[nearest[rows]]
        support = np.bincount(labels.link_point[rows][free] - first, minlength=last - first)
        own = ~taken[first:last]
        for a, b in _stretches(own & (support > 0) | own & runs.bridged[first:last]):
            confirmed = support[a:b] > 1
            alone = two_images[first + a : first + b].all() and b - a >= LEAST_PLACES_OF_TWO
            if confirmed.sum() < LEAST_PLACES and not alone:
                continue
            if not alone:
                a, b = _held(_beside_confirmed(chains, labels, begin, first + a, confirmed), confirmed, a)
            a, b = max(a - OVERLAP, 0), min(b + OVERLAP, last - first)
            out.append(Stretch(first + a, first + b))
            _take(chains, labels, begin, first + a, first + b, taken)
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
    chains: TracedChains, labels: LabelledPoints, begin: IntArray, first: int, confirmed: BoolArray
) -> BoolArray:
    """Places that three images see, and those of two that stay on a chain of them."""
    piece = chains.piece[labels.link_place.astype(np.int64)]
    count = len(confirmed)
    known = np.unique(
        np.concatenate([piece[begin[first + k] : begin[first + k + 1]] for k in np.flatnonzero(confirmed)])
    )
    rows = slice(begin[first], begin[first + count])
    beside = np.bincount(labels.link_point[rows] - first, np.isin(piece[rows], known), minlength=count) > 0
    return np.asarray(confirmed | beside)


def _take(
    chains: TracedChains, labels: LabelledPoints, begin: IntArray, first: int, last: int, taken: BoolArray
) -> None:
    """Mark the points of a stretch and those between its links as explained."""
    taken[first:last] = True
    place = labels.link_place[begin[first] : begin[last]]
    piece = chains.piece[place.astype(np.int64)]
    order = np.argsort(piece, kind="stable")
    piece, place = piece[order], place[order]
    new = np.flatnonzero(np.diff(piece, prepend=-1))
    if not len(new):
        return
    low, high = np.minimum.reduceat(place, new), np.maximum.reduceat(place, new)
    for a, b in zip(np.floor(low).astype(np.int64), np.ceil(high).astype(np.int64), strict=True):
        taken[a : b + 1] = True
