"""Which knots measurements support: segments with too few measured points are joined with a neighbour."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import IntArray

FEWEST = 4  # measured points in a segment


def supported_knots(number: IntArray, closed: bool, *, cut_ends: bool = True) -> IntArray:
    """Knots to keep so that every segment has enough measured points, by joining the poorest segments first.

    Parameters
    ----------
    number : (S,) measured points per segment
    cut_ends : whether an end segment without any point is cut off (else joined)
    """
    fewest_segments = 3 if closed else 1
    counts = [int(n) for n in number]
    knots = list(range(len(number) + (0 if closed else 1)))
    while len(counts) > fewest_segments and min(counts) < FEWEST:
        poor = int(np.argmin(counts))
        if cut_ends and not closed and counts[poor] == 0 and poor in (0, len(counts) - 1):
            del knots[0 if poor == 0 else -1], counts[poor]
            continue
        left, right = (poor - 1) % len(counts), (poor + 1) % len(counts)
        neighbours = [s for s in (left, right) if closed or abs(s - poor) == 1]
        other = min(neighbours, key=lambda s: counts[s])
        first, second = (poor, other) if (poor + 1) % len(counts) == other else (other, poor)
        del knots[second % len(knots)]  # the knot between them begins the second
        counts[first] += counts[second]
        del counts[second]
    return np.array(knots, dtype=np.int64)
