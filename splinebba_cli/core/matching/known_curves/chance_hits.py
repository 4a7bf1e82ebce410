"""Single points that lie near a curve by chance.

No chain speaks for a single point: all that tells a point of a curve from one anywhere is how the distances of many
are distributed.  With x = |d| / sqrt(var d) inside the gate g, those of curves follow a half normal distribution, those
of chance are uniform,

    p(x) = w 2 phi(x) / (2 Phi(g) - 1) + (1 - w) / g,

and the share w is estimated by expectation and maximisation (Dempster, Laird and Rubin 1977).  A point is taken where
the first term is the larger one.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from splinebba_cli.core.network import BoolArray, FloatArray

FEWEST = 20  # points whose distribution tells something
STEPS = 100
SETTLED = 1e-4  # change of the share


def likely_by_chance(distance: FloatArray, gate: float) -> BoolArray:
    """Points that chance explains better than a curve, (q,).

    Parameters
    ----------
    distance : (q,) of single points from their curves, over the predicted sigma, below the gate
    """
    if len(distance) < FEWEST:
        return np.zeros(len(distance), dtype=bool)
    on_curve = np.exp(-0.5 * distance**2) * np.sqrt(2.0 / np.pi) / (2.0 * ndtr(gate) - 1.0)
    by_chance = 1.0 / gate
    share = 0.9
    for _ in range(STEPS):
        before, responsibility = share, share * on_curve / (share * on_curve + (1.0 - share) * by_chance)
        share = float(np.clip(responsibility.mean(), 1e-3, 1.0 - 1e-6))
        if abs(share - before) < SETTLED:
            break
    return np.asarray(share * on_curve < (1.0 - share) * by_chance)
