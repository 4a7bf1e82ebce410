"""Given curves whose points show two edges: a kerb has two, a project one of them."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.candidates.search import find_candidates
from splinebba_cli.core.matching.matches import Matches, Reason
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.matching.shapes.known_edges import double_edge_problems
from splinebba_cli.core.network import Network
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import State

NEAR = 12.0  # sigma, within which points count as those of a curve
BESIDE = (Reason.MATCHED, Reason.TAKEN, Reason.GROSS)


def given_with_two_edges(network: Network, state: State, matches: Matches) -> tuple[Problem, ...]:
    """SBB598 for every curve with two clusters of chains beside each other.

    Parameters
    ----------
    state : of the curves of the network, after matching
    matches : of all unlabelled points; matched ones count, and those that lie beside what others have taken
    """
    points = network.unlabelled
    rows = np.flatnonzero(np.isin(matches.reason, BESIDE) & (points.chain >= 0))
    if not len(rows):
        return ()
    scene = Scene.of(network, state)
    near = find_candidates(scene, NEAR * scene.noise, rows)
    point, first = np.unique(near.point, return_index=True)  # the nearest curve of every point
    curve, offset, tangent = near.curve[first], near.offset[first], near.tangent[first]
    across = (tangent[:, 0] * offset[:, 1] - tangent[:, 1] * offset[:, 0]) / scene.noise[point]
    usable = np.isfinite(across) & ~near.at_end[first] & ~near.at_corner[first]
    own = np.flatnonzero(usable)
    row = point[own]
    found = double_edge_problems(
        network, curve[own], near.location[first[own]], across[own], points.image[row], points.chain[row]
    )
    return tuple(found)
