"""How far approximate shapes are taken to be off: no more than it takes to find their curves in two images.

A wide gate lets foreign chains in.  So the gate of a curve of approximate shape begins narrow, and is widened as long
as no two images have points on the curve.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.matching.known_curves.loop_context import LoopContext, Progress
from splinebba_cli.core.matching.known_curves.loop_network import Start
from splinebba_cli.core.network import FloatArray

SHARES = (0.1, 0.3, 1.0)  # of the standard deviation of approximate shapes


def narrow_shapes(start: Start) -> FloatArray:
    """Standard deviations (nc,) m of shapes to begin with."""
    return np.where(start.shaped & ~start.known, SHARES[0], 1.0) * start.shape_sigma


def with_shape_gates(context: LoopContext, progress: Progress) -> Progress:
    """Progress whose shapes are as uncertain as their curves need."""
    start = context.start
    rough = start.shaped & ~start.known
    images = len(context.network.images.ids)
    shape = narrow_shapes(start)
    for share in SHARES[1:]:
        progress = replace(progress, uncertainty=replace(progress.uncertainty, shape=shape))
        found = context.label(progress, start.shaped).matches
        rows = np.flatnonzero(found.curve >= 0)
        pairs = np.unique(found.curve[rows] * images + context.network.unlabelled.image[rows]) // images
        seen = np.bincount(pairs, minlength=len(shape))
        lost = rough & (seen < 2)
        if not lost.any():
            break
        shape = np.where(lost, share * start.shape_sigma, shape)
    return replace(progress, uncertainty=replace(progress.uncertainty, shape=shape))
