"""Curves whose links show two edges side by side: chains, or stretches of them, that are shifted across the curve.

A chain that was linked to the edge beside its own pulls the curve; single residuals stay small, because the curve and
the other chains share the error among themselves.  The test of a common shift (:mod:`.curve_normals`) adds up what all
of them show.  The group with the largest |w| is taken out, the curve adjusted, and tested again.  It works for curves
of known shape, too: there the shift is the mean distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from splinebba_cli.core.matching.shapes.curve_normals import CurveNormals, curve_normals
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

FEWEST = 6  # links of a group
APART = 3.0  # sigma between two edges; 4 pixels are about 6
CERTAIN = 1e-4  # probability of a wrong accusation among all groups of a curve
PARTS = (1, 2, 4)  # into which a chain is divided for the tests of stretches
ROUNDS = 12


@dataclass(frozen=True)
class OffEdge:
    """A stretch of a chain that lies beside the curve it was linked to."""

    curve: int
    row: IntArray  # unlabelled points
    chain: int
    image: int
    first: float  # location
    last: float
    shift: float  # sigma
    w: float


def without_second_edges(draft: Draft, chain: IntArray) -> tuple[Draft, list[OffEdge]]:
    """The draft without the links that belong to another edge, adjusted; and which they were.

    Parameters
    ----------
    chain : (n,) of all unlabelled points, -1: single
    """
    found: list[OffEdge] = []
    looked = np.arange(len(draft.curves))
    for _ in range(ROUNDS):
        worst = [off_edge(draft, own, chain) for own in curve_normals(draft, looked)]
        accused = [one for one in worst if one is not None]
        if not accused:
            break
        keep = ~np.isin(draft.row, np.concatenate([one.row for one in accused]))
        looked = np.array([one.curve for one in accused])
        draft = draft.with_links(keep).solved()
        found += accused
    return draft, found


def off_edge(draft: Draft, own: CurveNormals, chain: IntArray) -> OffEdge | None:
    """The group of links of a curve that is shifted most certainly; None where chance explains all."""
    if not len(own.link):
        return None
    groups = _groups(draft, own, chain)
    if len(groups) < 2:
        return None
    tests = [own.shift(group) for group in groups]
    best = int(np.argmax([abs(w) for _, w in tests]))
    shift, w = tests[best]
    if abs(w) < norm.isf(CERTAIN / (2.0 * len(groups))) or abs(shift) < APART:
        return None
    inside = groups[best]
    links = own.link[inside]
    at = own.location[inside]
    return OffEdge(
        int(draft.links.curve[links[0]]), draft.row[links], int(chain[draft.row[links[0]]]),
        int(draft.links.image[links[0]]), float(at.min()), float(at.max()), shift, w,
    )  # fmt: skip


def _groups(draft: Draft, own: CurveNormals, chain: IntArray) -> list[BoolArray]:
    """Links of every chain, whole and in parts along the curve, as masks of the links of a curve."""
    names = chain[draft.row[own.link]]
    single = names < 0
    names = np.where(single, -1 - draft.links.image[own.link], names)
    groups: list[BoolArray] = []
    for name in np.unique(names):
        members = np.flatnonzero(names == name)
        members = members[np.argsort(own.location[members], kind="stable")]
        for parts in PARTS:
            if len(members) >= FEWEST * parts:
                for part in np.array_split(members, parts):
                    mask = np.zeros(len(names), dtype=bool)
                    mask[part] = True
                    groups.append(mask)
    return groups


@dataclass(frozen=True)
class TwoClusters:
    """Chains that lie on two sides of a curve along a stretch of it."""

    first: float
    last: float
    apart: float  # sigma between the two
    minority: IntArray  # chains of the smaller side


def clusters_beside(location: FloatArray, residual: FloatArray, chain: IntArray) -> TwoClusters | None:
    """Whether the residuals across a curve of known shape come in two clusters, chain by chain.

    Parameters
    ----------
    location, residual : (n,) of matched points; residuals in their sigma
    chain : (n,) any numbers
    """
    names, number = np.unique(chain, return_inverse=True)
    size = np.bincount(number)
    use = np.flatnonzero(size >= FEWEST)
    if len(use) < 2:
        return None
    mean = np.array([np.median(residual[number == k]) for k in use])
    order = np.argsort(mean)
    gaps = np.diff(mean[order])
    cut = int(np.argmax(gaps))
    low, high = use[order[: cut + 1]], use[order[cut + 1 :]]
    apart = float(np.mean(mean[order[cut + 1 :]]) - np.mean(mean[order[: cut + 1]]))
    spread = max(np.ptp(mean[order[: cut + 1]]), np.ptp(mean[order[cut + 1 :]]))
    if gaps[cut] < APART or spread > 0.5 * apart:
        return None
    smaller = low if size[low].sum() < size[high].sum() else high
    at = location[np.isin(number, smaller)]
    return TwoClusters(float(at.min()), float(at.max()), apart, np.sort(names[smaller]))
