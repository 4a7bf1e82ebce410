"""The strands of one edge as a single one: order by location along the present line, fit, order again.

The longest strand is the first line.  The others are laid along it, the one with the longest common stretch first;
where they run beyond an end they make it longer.  What comes out is close to a principal curve of all places.

References
----------
Hastie, T., Stuetzle, W. (1989): Principal curves. Journal of the American Statistical Association 84, 502-516.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from splinebba_cli.core.matching.shapes.place_fit import fit_places
from splinebba_cli.core.matching.shapes.polyline_feet import feet_on_polyline
from splinebba_cli.core.matching.shapes.strand import SMOOTH_TOLERANCE, Strand, carrier, on_fit
from splinebba_cli.core.network import FloatArray

ROUNDS = 2
FEWEST_SHARED = 6  # image points that tell how two strands belong together
NEAR = 4.0  # spacings of places between strands without common image points
ALONG = 0.5  # cosine of their directions


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


def _common(present: Strand, other: Strand) -> tuple[FloatArray, FloatArray]:
    """Places on both that belong together, locations along the other (ascending) and along the present one.

    Image points of both say it; where there are too few of them, the places beside the present line.
    """
    _, a, b = np.intersect1d(present.link_row, other.link_row, return_indices=True)
    if len(a) >= FEWEST_SHARED:
        here, there = present.link_location[a], other.link_location[b]
    else:
        feet = feet_on_polyline(present.line, other.line, closed=present.closed)
        step = np.gradient(other.line, axis=0)
        cosine = np.sum(step * feet.tangent, axis=1) / np.maximum(np.linalg.norm(step, axis=1), 1e-300)
        reach = NEAR * max(present.spacing, other.spacing)
        near = feet.beside & (np.abs(cosine) > ALONG) & (np.linalg.norm(feet.offset, axis=1) < reach)
        table = present.location
        if present.closed:
            table = np.append(table, table[0] + present.period)
        here, there = np.interp(feet.place, np.arange(len(table)), table)[near], other.location[near]
    order = np.argsort(there, kind="stable")
    return there[order], here[order]


def _common_length(present: Strand, other: Strand) -> float:
    there, _ = _common(present, other)
    return float(there[-1] - there[0]) if len(there) >= 2 else 0.0


def _laid_along(present: Strand, other: Strand) -> Strand:
    """Both as one, with locations along the first."""
    there, here = _common(present, other)
    if present.closed:
        here = _unwrapped(here, present.period)
    half = len(here) // 2
    if np.median(here[half:]) < np.median(here[: max(half, 1)]):
        return _laid_along(present, other.reversed())
    here = np.maximum.accumulate(median_filter(here, min(5, len(here)), mode="nearest"))
    carried = carrier(there, here)
    location, link = carried(other.location), carried(other.link_location)
    if present.closed:
        low = present.location[0]
        location, link = (
            low + np.mod(location - low, present.period),
            low + np.mod(link - low, present.period),
        )
    new = ~np.isin(other.link_row, present.link_row)
    order = np.argsort(np.concatenate([present.location, location]), kind="stable")
    joined: dict[str, Any] = {
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
