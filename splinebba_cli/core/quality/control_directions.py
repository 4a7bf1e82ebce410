"""Directions of an error that all given values of one control feature share: given = true + d, d = (dX, dY, dZ).

Equations of given values (0 < sigma < infinity) are shifted by d / sigma.  A fixed value is no equation: its error
enters the image observations by - dp/dX d, for curves by the share of the removed coefficients at each measured point.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.residual_projector import ResidualProjector


def control_point_directions(projector: ResidualProjector, point: int, rays: IntArray) -> sparse.csc_array:
    """Of one control point with its image points `rays`, (rows, 3) 1/m."""
    assembler, ranges = projector.assembler, projector.design.ranges
    weight, fixed = assembler.point_inverse_sigma, assembler.layout.point_mask[point] == 0.0
    before = int((weight[:point] > 0.0).sum())
    out = sparse.lil_array((ranges.count, 3))
    for number, axis in enumerate(np.flatnonzero(weight[point] > 0.0)):
        out[ranges.control + before + number, axis] = weight[point, axis]
    rows = ranges.points + (2 * rays[:, None] + np.arange(2)).ravel()
    seen = -projector.solution.linearization.points.object_xyz[rays].reshape(-1, 3) * fixed
    return _with_rows(out, rows, seen)


def control_spline_directions(
    projector: ResidualProjector, curve: int, measured: IntArray
) -> sparse.csc_array:
    """Of one curve with given values and its rows `measured` among the curve rows, (rows, 3) 1/m.

    Arc lengths and tangents on a fixed spline would show it as well; they are left out here.
    """
    assembler, ranges = projector.assembler, projector.design.ranges
    prepared, at = assembler.prepared, projector.solution.linearization
    given, basis = prepared.network.curves[curve], prepared.curves.bases[curve]
    positions = FAMILIES[given.family].positions(len(given.values)).astype(float)
    share = np.zeros(len(assembler.layout.coefficient_mask))  # d coefficient / d shift
    own = slice(*prepared.curves.coefficient_start[curve : curve + 2].tolist())
    share[own] = basis.coefficients_from_values(np.tile(positions[:, None], (1, 3)))[:, 0]
    removed = share[:, None] * (1.0 - assembler.layout.coefficient_mask)  # (C, 3)
    columns = prepared.curves.columns[at.curve.segment[measured]]
    moved = np.einsum("kw,kwd->kd", at.curve.weights[measured], removed[columns])
    out = _with_rows(sparse.lil_array((ranges.count, 3)), measured, -at.curve.direction[measured] * moved)
    return sparse.csc_array(out + _value_directions(projector, curve, positions, removed))


def _value_directions(
    projector: ResidualProjector, curve: int, positions: FloatArray, removed: FloatArray
) -> sparse.csc_array:
    """Of the equations of given values: their targets move, and so do removed coefficients in them."""
    rows, ranges = projector.assembler.coefficient_rows, projector.design.ranges
    chosen = np.flatnonzero((rows.curve == curve) & (rows.component < 3))
    component = rows.component[chosen]
    values = positions[rows.row[chosen]] / rows.sigma[chosen]
    jacobian = rows.jacobian[chosen, :, component]
    values -= np.sum(jacobian * removed[rows.columns[chosen], component[:, None]], axis=1)
    place = (ranges.coefficients + chosen, component)
    return sparse.coo_array((values, place), shape=(ranges.count, 3)).tocsc()


def _with_rows(out: sparse.lil_array, rows: IntArray, values: FloatArray) -> sparse.csc_array:
    place = (rows.repeat(3), np.tile(np.arange(3), len(rows)))
    added = sparse.coo_array((values.ravel(), place), shape=out.shape)
    return sparse.csc_array(out + added.tocsc())
