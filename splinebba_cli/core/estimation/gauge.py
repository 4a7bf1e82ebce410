"""Which gauge conditions a network needs.

Every anchor of a free curve starts with its tangential condition.  At the solution a condition with
whitened leverage q = g Q g' takes 1 - q of redundancy: q = 1 where it only fills a defect, q near 0 where the
measurements determine the place along the curve without it.  The latter would bias v'Pv, so they are dropped and
the network is solved again; conditions come back where a knot then slides by more than their sigma.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray

KEEP_LEVERAGE = 0.9  # a knot that slides by more than three sigma of its condition


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
