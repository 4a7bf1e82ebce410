"""Fewer points of a chain: those that stand still, and those of a dense contour that say nearly the same."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray


def without_repeats(xy: FloatArray) -> FloatArray:
    """A chain without points that lie where the one before lies, as a double click makes them.

    Parameters
    ----------
    xy : (n, 2) float

    Returns
    -------
    (m, 2) float
    """
    return xy[np.append(True, (np.diff(xy, axis=0) != 0.0).any(axis=1))] if len(xy) else xy


def thinned(xy: FloatArray, spacing: float) -> FloatArray:
    """Points of a chain that are `spacing` apart along it, or a little more; its ends stay.

    No point is made or moved: the next one to stay is the first that is far enough along the chain from the one before.
    The last but one goes where it is nearer to the end than half the spacing.

    Parameters
    ----------
    xy : (n, 2) float
        In the order of tracing.
    spacing : float
        In the unit of `xy`, > 0.

    Returns
    -------
    (m, 2) float
    """
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(xy, axis=0).T)))
    kept = [0]
    while (following := int(np.searchsorted(along, along[kept[-1]] + spacing))) < len(xy):
        kept.append(following)
    last = len(xy) - 1
    if len(kept) > 1 and along[last] - along[kept[-1]] < 0.5 * spacing:
        kept.pop()
    return xy[[*kept, last]] if kept[-1] != last else xy[kept]
