"""Which conditions a network needs: gauge conditions of curves, and a minimal datum.

Gauge.  Every anchor of a free curve starts with its tangential condition.  At the solution a condition with
whitened leverage q = g Q g' takes 1 - q of redundancy: q = 1 where it only fills a defect, q near 0 where the
measurements determine the place along the curve without it.  The latter would bias v'Pv, so they are dropped and
the network is solved again; conditions come back where a knot then slides by more than their sigma.

Minimal datum.  Six orientation unknowns of one image and one coordinate of the image farthest from it are held: a
minimal constraint (S-basis) for shift, rotation and scale.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.estimation.parameters import ParameterLayout, layout_of
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.errors import SingularNetworkError

_NO_MINIMAL_DATUM = Problem(
    "SBB523",
    "error",
    "a minimal datum holds two images, but fewer than two are free",
    "datum",
    "use `adjustment: {datum: control}`, or free the orientations of two images",
)
KEEP_LEVERAGE = 0.9  # a knot that slides by more than three sigma of its condition
DATUM_DEFECT = 7


def needed_conditions(active: BoolArray, leverage: FloatArray) -> BoolArray:
    """Which gauge conditions to keep, by their leverage at the present solution.

    Parameters
    ----------
    active : (q,) whether a condition took part in the solution
    leverage : (q,) g Q g' of all conditions, in units of their sigma squared
    """
    return np.where(active, leverage > KEEP_LEVERAGE, leverage > KEEP_LEVERAGE / (1.0 - KEEP_LEVERAGE))


def jointly_needed(cofactors: FloatArray) -> BoolArray:
    """Which conditions of one curve to keep where several of them hold the same direction.

    One after another the condition with the smallest leverage is dropped; the others then take over its share,

        Q' = Q + q_i q_i' / (1 - q_ii),   q_i the column of the dropped one.

    Parameters
    ----------
    cofactors : (q, q) G Q G' of the conditions that took part, in units of their sigma squared
    """
    found = cofactors.copy()
    keep = np.ones(len(found), dtype=bool)
    while keep.any():
        weakest = np.flatnonzero(keep)[np.argmin(np.diag(found)[keep])]
        own = found[weakest, weakest]
        if own > KEEP_LEVERAGE:
            break
        found += np.outer(found[weakest], found[weakest]) / (1.0 - own)
        keep[weakest] = False
    return keep


def datum_layout(prepared: Prepared, state: State) -> ParameterLayout:
    """The layout of a network with the datum that its settings ask for."""
    layout = layout_of(prepared)
    return minimal_datum(layout, state) if prepared.network.settings.datum == "minimal" else layout


def minimal_datum(layout: ParameterLayout, state: State) -> ParameterLayout:
    """The layout with seven orientation unknowns held.

    Raises
    ------
    SingularNetworkError
        If fewer than two images are free.
    """
    free = np.flatnonzero((layout.image_mask > 0.0).all(axis=1))
    if len(free) < 2:
        raise SingularNetworkError([_NO_MINIMAL_DATUM])
    centre = state.position[free].mean(axis=0)
    first = free[np.argmax(np.linalg.norm(state.position[free] - centre, axis=1))]
    base = state.position[free] - state.position[first]
    second = free[np.argmax(np.linalg.norm(base, axis=1))]
    axis = int(np.argmax(np.abs(state.position[second] - state.position[first])))
    mask = layout.image_mask.copy()
    mask[first] = 0.0
    mask[second, 3 + axis] = 0.0
    return replace(layout, image_mask=mask)
