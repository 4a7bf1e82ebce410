"""Points of which the image itself says on which curve they lie: no other curve passes near.

A point is apart when every place of every other curve of the project is further than a limit from its true place in
the image, all projected with the true orientations, whether or not a surface hides them.  Other branches of its own
curve do not count: they have the same label.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.candidates.search import Candidates, find_candidates
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.state import State, initial_coefficients, prepare


def points_apart(exact: Network, label: IntArray, limit_mm: float) -> BoolArray:
    """Unlabelled points without another curve near, (n,).

    Parameters
    ----------
    exact : with true orientations and shapes, unlabelled points at their true places
    label : (n,) their curves
    """
    near = _near(exact, limit_mm)
    others = near.point[near.curve != label[near.point]]
    return np.asarray(np.bincount(others, minlength=len(label)) == 0)


def directions_along(exact: Network, label: IntArray, limit_mm: float) -> FloatArray:
    """Directions of the edges at unlabelled points, (n,) rad in the corrected photo; parameters as above."""
    near = _near(exact, limit_mm)
    own = np.flatnonzero(near.curve == label[near.point])
    points, first = np.unique(near.point[own], return_index=True)
    found = np.full(len(label), np.nan)
    found[points] = np.arctan2(*near.tangent[own[first]].T[::-1])
    return found


def _near(exact: Network, limit_mm: float) -> Candidates:
    """Places of curves near the unlabelled points."""
    prepared = prepare(exact)
    coefficients = initial_coefficients(prepared)
    state = State(exact.images.rotation, exact.images.position, coefficients, exact.points.xyz, np.zeros(0))
    return find_candidates(Scene.of(exact, state, prepared), np.full(len(exact.unlabelled), limit_mm))
