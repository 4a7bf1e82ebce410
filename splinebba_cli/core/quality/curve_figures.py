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

from splinebba_cli.core.estimation.curve_chunks import CHUNK, CurveChunk, CurveChunks, CurveEquations
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


def curve_figures(cofactors: Cofactors) -> CurveFigures:
    """Figures of all curve points of a solution."""
    assembler, at = cofactors.assembler, cofactors.solution.linearization
    observed, curves = assembler.prepared.network.curve_observations, assembler.prepared.curves
    equations = CurveEquations.begun(assembler, at)
    count = len(equations.point)
    found = CurveFigures(equations, np.zeros(count), np.zeros(count), np.zeros(len(observed)))
    free = curves.has_location[observed.curve] & ~assembler.prepared.chains.linked
    free[at.held] = False
    keys = observed.image * len(curves.bases) + observed.curve
    order = np.arange(len(keys)) if (keys[1:] >= keys[:-1]).all() else np.argsort(keys, kind="stable")
    weights, _ = cofactors.orientation_weights, cofactors.segments  # both before threads ask for them
    chunks = CurveChunks.at(assembler, at.state)

    def take(points: IntArray) -> None:
        chunk = chunks.of(points, np.arange(len(points)))
        leverage, share = _taken_up(cofactors, weights, chunk)
        number = equations.put(chunk)
        is_equation = number >= 0
        found.leverage[number[is_equation]] = leverage[is_equation]
        found.orientation_share[number[is_equation]] = share[is_equation]
        along = chunk.point[len(points) :]
        is_free = free[points[along]]
        speed = chunk.rows.speed[along[is_free]]
        inverse = 1.0 / np.where(speed > 0.0, speed, np.inf)
        found.location[points[along[is_free]]] = (1.0 + leverage[len(points) :][is_free]) * inverse**2

    in_threads(take, [order[begin : begin + CHUNK] for begin in range(0, len(order), CHUNK)])
    return found


def _taken_up(cofactors: Cofactors, weights: FloatArray, chunk: CurveChunk) -> tuple[FloatArray, FloatArray]:
    """Leverages of the equations of a chunk, and the share of the orientation of their image, (k,) each."""
    assembler = cofactors.assembler
    size = assembler.orientation_size
    groups = RowGroups.of(chunk.image * len(assembler.prepared.curves.left) + chunk.segment)
    image, segment = chunk.image[groups.representative], chunk.segment[groups.representative]
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
    return leverage[:-1], share[:-1]


def reached_by_datum(cofactors: Cofactors, chunk: CurveChunk) -> FloatArray:
    """G_i H'a' of the equations of a chunk, and a row of zeros, (k + 1, 6)."""
    assembler, image, datum = cofactors.assembler, chunk.image, cofactors.datum
    assert datum is not None
    columns = assembler.prepared.curves.columns[chunk.segment]
    size = assembler.orientation_size
    local = chunk.jacobian[:, size:]
    onto = np.einsum(
        "ki,kid->kd",
        chunk.rows.jacobian[:, :size] * datum.image_mask[image],
        datum.partner.orientation[image],
    )
    partner = datum.partner.coefficients * assembler.layout.coefficient_mask[:, :, None]
    onto += np.einsum("kp,kpd->kd", local, partner[columns].reshape(*local.shape, -1))
    moved = np.einsum("kid,kd->ki", datum.columns.directions.orientation[image], onto)
    return np.concatenate([moved, np.zeros((1, moved.shape[1]))])
