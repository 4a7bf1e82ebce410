"""What the unknowns take up of the equations of all curve points, chunk by chunk.

With a the row of an equation over the orientation of its image and the coefficients of its segment, q = a Q_.i,

    leverage             a Q a'
    share of the image   q Q_ii^-1 q'
    cofactor of u        (1 + a_along Q a_along') / |b|^2       of a location that nothing links or holds

|b| the whitened length of the projected tangent.  Points of one image and segment share their block of Q.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from splinebba_cli.core.estimation.curve_chunks import CHUNK, CurveChunk, CurveEquations, curve_chunk
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.row_groups import RowGroups
from splinebba_cli.core.threads import in_threads

if TYPE_CHECKING:
    from splinebba_cli.core.quality.cofactors import Cofactors


@dataclass(frozen=True)
class CurveFigures:
    """Figures of all equations of curve points, in whitened units."""

    equations: CurveEquations
    leverage: FloatArray  # (k,)
    orientation_share: FloatArray  # (k,) part of it that the orientation of the image has
    location: (
        FloatArray  # (n,) cofactor of the location; 0 where it is held or linked, or where there is none
    )


@dataclass(frozen=True)
class _ChunkFigures:
    chunk: CurveChunk
    leverage: FloatArray  # (k,)
    share: FloatArray  # (k,)


def curve_figures(cofactors: Cofactors) -> CurveFigures:
    """Figures of all curve points of a solution."""
    assembler, at = cofactors.assembler, cofactors.solution.linearization
    observed, curves = assembler.prepared.network.curve_observations, assembler.prepared.curves
    equations = CurveEquations.begun(assembler, at)
    leverage, share = np.zeros(len(equations.point)), np.zeros(len(equations.point))
    location = np.zeros(len(observed))
    free = curves.has_location[observed.curve] & ~assembler.prepared.chains.linked
    free[at.held] = False
    keys = observed.image * len(curves.bases) + observed.curve
    order = np.arange(len(keys)) if (keys[1:] >= keys[:-1]).all() else np.argsort(keys, kind="stable")
    parts = [order[begin : begin + CHUNK] for begin in range(0, len(order), CHUNK)]
    weights, _ = cofactors.orientation_weights, cofactors.segments  # both before threads ask for them
    for part in in_threads(lambda points: _of_chunk(cofactors, weights, points), parts):
        points, rows = part.chunk.points, part.chunk.rows
        number = equations.put(part.chunk)
        is_equation = number >= 0
        leverage[number[is_equation]] = part.leverage[is_equation]
        share[number[is_equation]] = part.share[is_equation]
        along = rows.point[len(points) :]
        along_leverage = part.leverage[len(points) :][free[points[along]]]
        along = along[free[points[along]]]
        speed = rows.speed[along]
        location[points[along]] = (1.0 + along_leverage) / np.where(speed > 0.0, speed, np.inf) ** 2
    return CurveFigures(equations, leverage, share, location)


def _of_chunk(cofactors: Cofactors, weights: FloatArray, points: IntArray) -> _ChunkFigures:
    """Leverages of the equations across and along of some points."""
    assembler, state = cofactors.assembler, cofactors.solution.state
    size = assembler.orientation_size
    chunk = curve_chunk(assembler, state, points, np.arange(len(points)))
    rows = chunk.rows
    groups = RowGroups.of(rows.image * len(assembler.prepared.curves.left) + rows.segment)
    image, segment = rows.image[groups.representative], rows.segment[groups.representative]
    padded = np.concatenate([chunk.jacobian, np.zeros((1, chunk.jacobian.shape[1]))])
    leverage, share = np.zeros(len(padded)), np.zeros(len(padded))
    moved = None if cofactors.datum is None or not size else reached_by_datum(cofactors, chunk)
    for chosen, members in groups.batches(padded.shape[1] * 2):
        block = padded[members]
        inner = np.matmul(block, cofactors.curve_windows(image[chosen], segment[chosen]))
        leverage[members] = np.sum(inner * block, axis=2)
        reached = inner[:, :, :size]
        if moved is not None:
            reached = reached - moved[members]
        if size:
            share[members] = np.sum(np.matmul(reached, weights[image[chosen]]) * reached, axis=2)
    return _ChunkFigures(chunk, leverage[:-1], share[:-1])


def reached_by_datum(cofactors: Cofactors, chunk: CurveChunk) -> FloatArray:
    """G_i H'a' of the equations of a chunk, and a row of zeros, (k + 1, 6)."""
    assembler, rows, datum = cofactors.assembler, chunk.rows, cofactors.datum
    assert datum is not None
    columns = assembler.prepared.curves.columns[rows.segment]
    local = chunk.jacobian[:, assembler.orientation_size :]
    onto = np.einsum(
        "ki,kid->kd", rows.orientation * datum.image_mask[rows.image], datum.partner.orientation[rows.image]
    )
    partner = datum.partner.coefficients * assembler.layout.coefficient_mask[:, :, None]
    onto += np.einsum("kp,kpd->kd", local, partner[columns].reshape(*local.shape, -1))
    moved = np.einsum("kid,kd->ki", datum.columns.directions.orientation[rows.image], onto)
    return np.concatenate([moved, np.zeros((1, moved.shape[1]))])
