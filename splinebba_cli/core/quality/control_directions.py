"""Directions of an error that all given values of one control feature share: given = true + d, d = (dX, dY, dZ).

Equations of given values (0 < sigma < infinity) are shifted by d / sigma.  A fixed value is no equation: its error
enters the image observations by - dp/dX d, for curves by the share of the removed coefficients at each measured point.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.estimation.curve_chunks import equation_rows
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.coefficient_rows import GAUGE
from splinebba_cli.core.quality.residual_projector import ResidualProjector


def control_point_directions(projector: ResidualProjector, point: int, rays: IntArray) -> sparse.csc_array:
    """Of one control point with its image points `rays`, (rows, 3) 1/m."""
    assembler, ranges = projector.assembler, projector.design.ranges
    weight, fixed = assembler.point_inverse_sigma, assembler.layout.point_mask[point] == 0.0
    known = np.flatnonzero(weight[point] > 0.0)
    before = int((weight[:point] > 0.0).sum())
    rows = ranges.points + (2 * rays[:, None] + np.arange(2)).ravel()
    seen = -projector.solution.linearization.points.object_xyz[rays].reshape(-1, 3) * fixed
    return _matrix(
        projector,
        np.concatenate([ranges.control + before + np.arange(len(known)), rows.repeat(3)]),
        np.concatenate([known, np.tile(np.arange(3), len(rows))]),
        np.concatenate([weight[point, known], seen.ravel()]),
    )


def control_spline_directions(
    projector: ResidualProjector, curve: int, measured: IntArray
) -> sparse.csc_array:
    """Of one curve with given values and its rows `measured` among the curve rows, (rows, 3) 1/m.

    Arc lengths and tangents on a fixed spline would show it as well; they are left out here.
    """
    assembler = projector.assembler
    prepared = assembler.prepared
    given, basis = prepared.network.curves[curve], prepared.curves.bases[curve]
    positions = FAMILIES[given.family].positions(len(given.values)).astype(float)
    share = np.zeros(len(assembler.layout.coefficient_mask))  # d coefficient / d shift
    own = slice(*prepared.curves.coefficient_start[curve : curve + 2].tolist())
    share[own] = basis.coefficients_from_values(np.tile(positions[:, None], (1, 3)))[:, 0]
    removed = share[:, None] * (1.0 - assembler.layout.coefficient_mask)  # (C, 3)
    rows, _ = equation_rows(assembler, projector.solution.linearization, measured)
    moved = np.einsum("kw,kwd->kd", rows.weights, removed[prepared.curves.columns[rows.segment]])
    image = -rows.direction * moved
    value_rows, component, values = _value_directions(projector, curve, positions, removed)
    return _matrix(
        projector,
        np.concatenate([measured.repeat(3), value_rows]),
        np.concatenate([np.tile(np.arange(3), len(measured)), component]),
        np.concatenate([image.ravel(), values]),
    )


def _value_directions(
    projector: ResidualProjector, curve: int, positions: FloatArray, removed: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Rows, coordinates and values of the equations of given values: their targets move, so do removed coefficients."""
    rows, ranges = projector.assembler.coefficient_rows, projector.design.ranges
    chosen = np.flatnonzero((rows.curve == curve) & (rows.component < GAUGE))
    component = rows.component[chosen]
    values = positions[rows.row[chosen]] / rows.sigma[chosen]
    jacobian = rows.jacobian[chosen, :, component]
    values -= np.sum(jacobian * removed[rows.columns[chosen], component[:, None]], axis=1)
    return ranges.coefficients + chosen, component, values


def _matrix(
    projector: ResidualProjector, rows: IntArray, columns: IntArray, values: FloatArray
) -> sparse.csc_array:
    return sparse.coo_array((values, (rows, columns)), shape=(projector.design.ranges.count, 3)).tocsc()
