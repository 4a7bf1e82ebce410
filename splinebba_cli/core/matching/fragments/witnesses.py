"""Images that should see a fragment: a real edge is seen by most images between those that found it.

An image lies between them where its direction of view is no farther from their mean direction than theirs; it can see
the place where its frame holds it.  Chance agreement of a few images out of many has unseeing ones in between.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.frames import Frames
from splinebba_cli.core.matching.fragments.views import Views
from splinebba_cli.core.network import BoolArray, FloatArray

SAMPLES = 7  # places of a fragment that are looked at


def seeing_share(views: Views, frames: Frames, xyz: FloatArray, seen: BoolArray) -> float:
    """Share of the images that see a fragment among those that should.

    Parameters
    ----------
    xyz : (k, 3) places
    seen : (k, m) whether an image has linked points there
    """
    rows = np.unique(np.linspace(0, len(xyz) - 1, SAMPLES).astype(np.int64))
    xyz, seen = xyz[rows], seen[rows]
    direction = xyz[:, None, :] - views.position
    direction = direction / np.linalg.norm(direction, axis=2, keepdims=True)
    mean = np.where(seen[:, :, None], direction, 0.0).sum(axis=1)
    mean = mean / np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
    cosine = np.einsum("kmi,ki->km", direction, mean)
    widest = np.where(seen, cosine, 1.0).min(axis=1)
    between = ~seen & (cosine >= widest[:, None]) & (seen.sum(axis=1) > 0)[:, None]
    place, image = np.nonzero(between)
    missing = int(frames.shows(views, image, xyz[place]).sum())
    found = int(seen.sum())
    return found / (found + missing) if found else 0.0


def third_image_possible(views: Views, frames: Frames, xyz: FloatArray, pair: BoolArray) -> BoolArray:
    """Places that the frame of an image beside a pair holds, (k,).

    Parameters
    ----------
    pair : (m,) images that found the places
    """
    out = np.zeros(len(xyz), dtype=bool)
    for k in np.flatnonzero(~pair & np.isfinite(views.position).all(axis=1)):
        out |= frames.shows(views, np.full(len(xyz), k), xyz)
    return out
