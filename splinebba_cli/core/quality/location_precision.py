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
    size, layout = cofactors.assembler.orientation_size, cofactors.assembler.layout
    jacobian, slope = np.zeros((len(at.curve.point), at.curve_jacobian.shape[1] - 1)), np.zeros(len(rows))
    for begin in range(0, len(rows), CHUNK):
        part = rows[begin : begin + CHUNK]
        along = along_rows(prepared, at.state, part)
        image, columns = at.curve.image[part], prepared.curves.columns[along.segment]
        jacobian[part, :size] = (along.orientation * layout.image_mask[image])[:, :size]
        local = along.coefficients * layout.coefficient_mask[columns]
        jacobian[part, size:] = local.reshape(len(part), jacobian.shape[1] - size)
        slope[begin : begin + CHUNK] = np.where(along.slope > 0.0, along.slope, np.inf)
    out[rows] = (1.0 + cofactors.curve_leverage(jacobian).own[rows]) / slope**2
    return out
