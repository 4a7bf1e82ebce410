"""What becomes of links that belong to the edge beside a curve: a curve of their own where two images show it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.shapes.double_edges import OffEdge, without_second_edges
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.extent import cut_back
from splinebba_cli.core.matching.shapes.names import new_ids
from splinebba_cli.core.network import IntArray, Network

FEWEST = 8  # links of a curve
FITS = 1.5  # rms in sigma of links that are one edge


@dataclass(frozen=True)
class SecondEdge:
    """Two edges that were linked to one curve."""

    curve: str  # id
    other: str | None  # id of the curve of the second edge; None: its points have no curve
    off: tuple[OffEdge, ...]


def split(network: Network, draft: Draft, chain: IntArray) -> tuple[Draft, list[SecondEdge]]:
    """A draft in which every curve shows one edge.

    Parameters
    ----------
    chain : (n,) of all unlabelled points, -1: single
    """
    ids = [curve.id for curve in draft.curves]
    draft, off = without_second_edges(draft, chain)
    found: list[SecondEdge] = []
    for k in sorted({one.curve for one in off}):
        own = tuple(one for one in off if one.curve == k)
        rows = np.unique(np.concatenate([one.row for one in own]))
        second = _own_curve(network, draft, k, rows)
        other = None
        if second is not None:
            taken = [curve.id for curve in (*network.curves, *draft.curves)]
            (other,) = new_ids(1, taken)
            draft = _with_second(network, draft, second, other)
        found.append(SecondEdge(ids[k], other, own))
    return draft, found


def _own_curve(network: Network, draft: Draft, k: int, rows: IntArray) -> Draft | None:
    """The second edge adjusted by itself from the shape of the first; None where its points make no curve."""
    if len(rows) < FEWEST or len(np.unique(network.unlabelled.image[rows])) < 2:
        return None
    curve = draft.present_curves()[k]
    nothing = np.full(len(rows), np.nan)
    second = draft_of(network, draft.state, (curve,), rows, np.zeros(len(rows), dtype=np.int64), nothing)
    second = cut_back(second.solved()).solved()
    residual = second.equations().residual[: len(second.row)]
    if len(residual) < FEWEST or len(np.unique(second.links.image)) < 2:
        return None
    return second if float(np.sqrt(np.mean(residual**2))) < FITS else None


def _with_second(network: Network, draft: Draft, second: Draft, id: str) -> Draft:
    """Both drafts as one."""
    curves = (*draft.present_curves(), replace(second.present_curves()[0], id=id))
    row = np.concatenate([draft.row, second.row])
    curve = np.concatenate([draft.links.curve, np.full(len(second.row), len(curves) - 1)])
    location = np.concatenate([draft.state.location, second.state.location])
    return draft_of(network, draft.state, curves, row, curve, location)
