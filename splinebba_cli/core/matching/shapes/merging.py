"""The strands of one edge as a single one: order by location along the present line, fit, order again.

The longest strand is the first line.  The others are laid along it, the one with the longest common stretch first; where
they run beyond an end they make it longer.  What comes out is close to a principal curve of all places.

References
----------
Hastie, T., Stuetzle, W. (1989): Principal curves. Journal of the American Statistical Association 84, 502-516.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.matching.shapes.place_fit import fit_places
from splinebba_cli.core.matching.shapes.polyline_feet import feet_on_polyline
from splinebba_cli.core.matching.shapes.strand import SMOOTH_TOLERANCE, Strand, on_fit
from splinebba_cli.core.network import FloatArray

ROUNDS = 2


def merged(strands: list[Strand]) -> Strand:
    """One strand of all places and links.

    Parameters
    ----------
    strands : of one edge, one or more; those without a common stretch with the others are left out
    """
    if len(strands) == 1:
        return strands[0]
    waiting = sorted(strands, key=lambda s: (not s.closed, -s.length))
    present = waiting.pop(0)
    while waiting:
        stretch = [_common_length(present, other) for other in waiting]
        best = int(np.argmax(stretch))
        if stretch[best] <= 0.0:
            break
        present = _laid_along(present, waiting.pop(best))
    return refitted(present)


def refitted(strand: Strand, rounds: int = ROUNDS) -> Strand:
    """A strand in the order along a curve through all its places."""
    for _ in range(rounds):
        strand = on_fit(fit_places(strand.places, SMOOTH_TOLERANCE), strand)
    return strand


def _common_length(present: Strand, other: Strand) -> float:
    beside = feet_on_polyline(present.line, other.line, closed=present.closed).beside
    return float(other.length * beside.mean()) if np.count_nonzero(beside) >= 2 else 0.0


def _laid_along(present: Strand, other: Strand) -> Strand:
    """Both as one, with locations along the first."""
    feet = feet_on_polyline(present.line, other.line, closed=present.closed)
    index = np.arange(len(present.location) + present.closed)
    table = (
        np.append(present.location, present.location[0] + present.period)
        if present.closed
        else present.location
    )
    along = np.interp(feet.place, index, table)
    if present.closed:
        along = _unwrapped(along, present.period)
    inside = np.flatnonzero(feet.beside)
    if along[inside[-1]] < along[inside[0]]:
        return _laid_along(present, other.reversed())
    location = np.interp(other.location, other.location[inside], np.maximum.accumulate(along[inside]))
    own = other.location
    location += np.minimum(own - own[inside[0]], 0.0) + np.maximum(own - own[inside[-1]], 0.0)
    link = np.interp(other.link_location, own, location)
    if present.closed:
        low = present.location[0]
        location, link = (
            low + np.mod(location - low, present.period),
            low + np.mod(link - low, present.period),
        )
    new = ~np.isin(other.link_row, present.link_row)
    order = np.argsort(np.concatenate([present.location, location]), kind="stable")
    joined = {
        name: np.concatenate([getattr(present, name), getattr(other, name)])[order]
        for name in ("xyz", "line", "dispersion", "image_count", "weak")
    }
    together = replace(
        present,
        **joined,
        location=np.concatenate([present.location, location])[order],
        link_row=np.concatenate([present.link_row, other.link_row[new]]),
        link_location=np.concatenate([present.link_location, link[new]]),
    )
    return replace(together, line=_thinned_line(together))


def _thinned_line(strand: Strand) -> FloatArray:
    """The line of laid strands as the running mean of places, so that it does not go back and forth."""
    location, line = strand.location, strand.line
    half = 2
    window = np.clip(np.arange(len(line))[:, None] + np.arange(-half, half + 1), 0, len(line) - 1)
    smooth = line[window].mean(axis=1)
    smooth[[0, -1]] = line[[0, -1]]
    step = np.diff(location, prepend=location[0] - 1.0)
    same = step <= 0.0
    smooth[same] = smooth[np.maximum(np.flatnonzero(same) - 1, 0)] if same.any() else smooth[same]
    return np.asarray(smooth)


def _unwrapped(along: FloatArray, period: float) -> FloatArray:
    """Locations on a ring without the jump from its end to its begin, (n,)."""
    return np.asarray(np.unwrap(along, period=period))
