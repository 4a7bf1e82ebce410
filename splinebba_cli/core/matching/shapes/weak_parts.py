"""Stretches of new curves that their images hold weakly, and those that nothing determines.

    bridged      no two images have links there: the shape is that of the smoothest continuation
    epipolar     two images or more have links, but the curve runs along their epipolar lines: sigma is large
    two_images   two images see it: no third one confirms it

Where sigma is beyond UNDETERMINED times the usual one the curve is cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from splinebba_cli.core.matching.matches import WeakPart
from splinebba_cli.core.matching.shapes.curve_normals import CurveNormals
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray

WEAK = 3.0  # times the usual sigma
UNDETERMINED = 30.0
NEAR = 2.5  # spacings within which a link shows that an image sees a place
SAMPLES_PER_SPACING = 1.0
MOST_SAMPLES = 2000


@dataclass(frozen=True)
class Seen:
    """Places along a curve, how many images see them, and how well they are known."""

    location: FloatArray  # (p,)
    images: IntArray  # (p,)
    sigma: FloatArray  # (p,) m, largest across
    step: FloatArray  # (p,) metres that a place stands for


def seen_places(draft: Draft, own: CurveNormals, spacing: float) -> Seen:
    """Places at about the spacing of the measured points."""
    breaks = own.basis.break_points
    length = float(breaks[-1] - breaks[0])
    count = int(np.clip(SAMPLES_PER_SPACING * length / max(spacing, 1e-300), 8, MOST_SAMPLES))
    u = breaks[0] + length * (np.arange(count) + 0.5) / count
    image = draft.links.image[own.link]
    images = np.zeros(count, dtype=np.int64)
    for k in np.unique(image):
        at = np.sort(own.location[image == k])
        after = np.clip(np.searchsorted(at, u), 1, max(len(at) - 1, 1))
        nearest = np.minimum(np.abs(u - at[after - 1]), np.abs(u - at[np.minimum(after, len(at) - 1)]))
        images += nearest <= NEAR * spacing
    speed = np.linalg.norm(own.basis.evaluate(u, own.coefficients, 1), axis=1)
    return Seen(u, images, own.sigma_across(u), speed * length / count)


def weak_parts(seen: Seen, usual: float) -> tuple[WeakPart, ...]:
    """The weak stretches of a curve, in the order along it.

    Parameters
    ----------
    usual : median of sigma across, metres, of all new curves
    """
    weak = seen.sigma > WEAK * usual
    kind = np.where(seen.images < 2, 1, np.where(weak, 2, np.where(seen.images == 2, 3, 0)))
    names = {1: "bridged", 2: "epipolar", 3: "two_images"}
    half = 0.5 * float(seen.location[1] - seen.location[0])  # a place stands for the stretch about it
    found = []
    for first, stop in _runs(kind):
        if kind[first]:
            found.append(
                WeakPart(
                    float(seen.location[first]) - half, float(seen.location[stop - 1]) + half, names[int(kind[first])],
                    float(seen.sigma[first:stop].max()),
                )
            )  # fmt: skip
    return tuple(found)


def determined_parts(seen: Seen, usual: float) -> list[tuple[float, float]]:
    """Stretches between what nothing determines, from location to location; empty where all is determined."""
    open_: BoolArray = seen.sigma > UNDETERMINED * usual
    if not open_.any():
        return []
    kept = [(first, stop) for first, stop in _runs(open_.astype(np.int64)) if not open_[first]]
    return [(float(seen.location[first]), float(seen.location[stop - 1])) for first, stop in kept]


def _runs(values: IntArray) -> list[tuple[int, int]]:
    """First and one behind last place of every run of equal values."""
    cuts = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return [(a, b) for a, b in pairwise(cuts) if b > a]
