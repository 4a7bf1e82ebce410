"""Points linked to curves chain by chain: the cheapest sequence of curves along every chain.

    cost of a point on a curve   (distance across over sigma)^2, only inside the gate and where directions agree
    cost of no curve             GATE^2
    cost of a change             CHANGE, so that a chain does not jump to a curve that it crosses

found by dynamic programming.  A point beyond an end of a curve is not on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.matching.candidates.search import Candidates, find_candidates
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import State

CHANGE = 12.0
BEYOND = 4.0  # sigma along the curve from its end


@dataclass(frozen=True)
class Gate:
    """What may be linked."""

    width: float  # sigma across
    direction_rad: float
    refused: frozenset[tuple[int, int]] = frozenset()  # pairs of an unlabelled point and a curve


def relinked(network: Network, draft: Draft, rows: IntArray, gate: Gate) -> Draft:
    """The draft with points linked anew to the curves as they are now.

    Parameters
    ----------
    rows : (q,) unlabelled points that may be linked
    """
    found = links_to(network, draft, rows, gate)
    keep = found[1] >= 0
    return draft_of(network, draft.state, draft.present_curves(), rows[keep], found[1][keep], found[2][keep])


def links_to(
    network: Network, draft: Draft, rows: IntArray, gate: Gate
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Distance over sigma (inf: none near), curve (-1: none) and location of points, (q,) each."""
    scene = _scene(network, draft)
    sigma = 1.0 / np.abs(scene.whitening[:, [0, 1], [0, 1]]).mean(axis=1)
    near = find_candidates(scene, gate.width * sigma, rows)
    place = np.full(len(scene.image), -1)
    place[rows] = np.arange(len(rows))
    across = _across(scene, near, sigma)
    along = np.abs(np.sum(near.offset * near.tangent, axis=1)) / sigma[near.point]
    direction = edge_directions(scene)[near.point]
    tangent = np.arctan2(near.tangent[:, 1], near.tangent[:, 0])
    turn = np.abs((direction - tangent + 0.5 * np.pi) % np.pi - 0.5 * np.pi)
    allowed = (across <= gate.width) & (along <= BEYOND) & ~(turn > gate.direction_rad)
    if gate.refused:
        pairs = zip(near.point.tolist(), near.curve.tolist(), strict=True)
        allowed &= np.array([pair not in gate.refused for pair in pairs], dtype=bool)
    own = np.flatnonzero(allowed)
    best = own[np.lexsort((across[own], near.curve[own], place[near.point[own]]))]
    first = np.ones(len(best), dtype=bool)
    first[1:] = (near.point[best[1:]] != near.point[best[:-1]]) | (
        near.curve[best[1:]] != near.curve[best[:-1]]
    )
    best = best[first]
    table = _Costs(place[near.point[best]], near.curve[best], across[best], near.location[best])
    return _cheapest(scene.chain[rows], table, gate)


@dataclass(frozen=True)
class _Costs:
    """Possible links: place among the rows, curve, distance over sigma, location; sorted by place."""

    place: IntArray
    curve: IntArray
    distance: FloatArray
    location: FloatArray


def _cheapest(chain: IntArray, table: _Costs, gate: Gate) -> tuple[FloatArray, IntArray, FloatArray]:
    count = len(chain)
    distance, curve, location = np.full(count, np.inf), np.full(count, -1), np.full(count, np.nan)
    begin = np.searchsorted(table.place, np.arange(count + 1))
    starts = np.flatnonzero(np.concatenate([[True], (chain[1:] != chain[:-1]) | (chain[1:] < 0)]))
    for first, stop in zip(starts, [*starts[1:], count], strict=True):
        part = slice(int(begin[first]), int(begin[stop]))
        if part.start == part.stop:
            continue
        states, state = np.unique(table.curve[part], return_inverse=True)
        cost = np.full((stop - first, len(states) + 1), np.inf)
        cost[:, -1] = gate.width**2
        cost[table.place[part] - first, state] = table.distance[part] ** 2
        chosen = cheapest_path(cost)
        link = np.full((stop - first, len(states) + 1), -1)
        link[table.place[part] - first, state] = np.arange(part.start, part.stop)
        taken = link[np.arange(stop - first), chosen]
        own = np.flatnonzero(taken >= 0)
        distance[first + own], location[first + own] = table.distance[taken[own]], table.location[taken[own]]
        curve[first + own] = table.curve[taken[own]]
    return distance, curve, location


def cheapest_path(cost: FloatArray) -> IntArray:
    """Cheapest state at every place, changes priced, (n,)."""
    best, back = cost[0], np.zeros(cost.shape, dtype=np.int64)
    stay = np.arange(cost.shape[1])
    for k in range(1, len(cost)):
        cheapest = int(np.argmin(best))
        change = best[cheapest] + CHANGE < best
        back[k] = np.where(change, cheapest, stay)
        best = np.where(change, best[cheapest] + CHANGE, best) + cost[k]
    path = np.empty(len(cost), dtype=np.int64)
    path[-1] = int(np.argmin(best))
    for k in range(len(cost) - 1, 0, -1):
        path[k - 1] = back[k, path[k]]
    return path


def _scene(network: Network, draft: Draft) -> Scene:
    """The new curves before all unlabelled points."""
    whole = replace(draft.prepared.network, unlabelled=network.unlabelled)
    state = State(
        draft.state.rotation, draft.state.position, draft.state.coefficients, draft.state.xyz, draft.state.location
    )  # fmt: skip
    return Scene.of(whole, state, draft.prepared)


def _across(scene: Scene, near: Candidates, sigma: FloatArray) -> FloatArray:
    """Distance of candidates across the projected curve over sigma, (k,)."""
    cross = near.offset[:, 0] * near.tangent[:, 1] - near.offset[:, 1] * near.tangent[:, 0]
    return np.asarray(np.abs(cross) / sigma[near.point])


def edge_directions(scene: Scene) -> FloatArray:
    """Direction of the edge at every point, rad: as measured, or from its neighbours on the chain; NaN unknown."""
    count, chain = len(scene.chain), scene.chain
    number = np.arange(count)
    after, before = np.minimum(number + 2, count - 1), np.maximum(number - 2, 0)
    after = np.where(chain[after] == chain, after, number)
    before = np.where(chain[before] == chain, before, number)
    step = scene.xy[after] - scene.xy[before]
    angle = np.where((chain >= 0) & (after > before), np.arctan2(step[:, 1], step[:, 0]), np.nan)
    return np.where(np.isfinite(scene.direction), scene.direction, angle)
