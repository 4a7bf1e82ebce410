"""Cofactors of the locations of all measured curve points.

A point that nothing links to others has, with the equation along the curve a p + |b| u,

    Q_uu = (1 + a Q a') / |b|^2.

Like every figure along a curve it depends on the gauge.  A location that is held has none.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import LinkedCofactors

CHUNK = 20_000


def location_cofactors(cofactors: Cofactors, linked: LinkedCofactors) -> FloatArray:
    """Q_uu of every measured point, (n,); 0 where the location is held."""
    at, prepared = cofactors.solution.linearization, cofactors.assembler.prepared
    out = linked.location.copy()
    single = ~prepared.chains.linked
    single[at.held] = False
    has = prepared.curves.has_location[prepared.network.curve_observations.curve]
    rows = np.flatnonzero(single & has)
    if not len(rows):
        return out
    groups = at.windows.groups
    group_of = np.empty(len(groups.order), dtype=np.int64)
    group_of[groups.order] = np.repeat(np.arange(len(groups.starts) - 1), np.diff(groups.starts))
    size, layout = cofactors.assembler.orientation_size, cofactors.assembler.layout
    for begin in range(0, len(rows), CHUNK):
        part = rows[begin : begin + CHUNK]
        along = along_rows(prepared, at.state, part)
        image, columns = at.curve.image[part], prepared.curves.columns[along.segment]
        jacobian = np.concatenate(
            [
                (along.orientation * layout.image_mask[image])[:, :size],
                (along.coefficients * layout.coefficient_mask[columns]).reshape(len(part), -1),
            ],
            axis=1,
        )
        windows = cofactors.values[at.windows.window.index[group_of[part]]]
        leverage = np.sum(np.matmul(jacobian[:, None, :], windows)[:, 0] * jacobian, axis=1)
        slope = np.where(along.slope > 0.0, along.slope, np.inf)
        out[part] = (1.0 + leverage) / slope**2
    return out
