"""The dense design matrix of a small network, for rank and names of null directions.

Rows are whitened equations with the locations already eliminated (each elimination is orthogonal and takes exactly
one from equations and rank); columns are all unknowns that are not removed, points included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import ParameterLayout
from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class DesignMatrix:
    """Whitened equations over all unknowns that are not removed."""

    matrix: FloatArray  # (rows, columns)
    unknown: IntArray  # (columns,) number in the numbering reduced unknowns, then points


def unknown_count(layout: ParameterLayout) -> int:
    """Number of unknowns without locations, removed ones not counted."""
    return layout.free_count


def design_matrix(
    assembler: Assembler, at: Linearization, *, coefficient_rows: IntArray | None = None
) -> DesignMatrix:
    """All equations at one state.

    Parameters
    ----------
    coefficient_rows : which of the assembler's coefficient rows take part (default all)
    """
    network, layout = assembler.prepared.network, assembler.layout
    width = int(layout.node_starts[-1]) + 3 * len(network.points.ids)
    parts = [
        _curve_part(assembler, at, width),
        *_linked_parts(at, width),
        _point_part(assembler, at, width),
        _distance_part(assembler, at, width),
        _prior_part(assembler, at, width),
        _coefficient_part(assembler, at, width, coefficient_rows),
    ]
    mask = np.concatenate([assembler.mask, layout.eliminated_mask.ravel()])
    columns = np.flatnonzero(mask > 0.0)
    return DesignMatrix(np.vstack(parts)[:, columns], columns)


def _curve_part(assembler: Assembler, at: Linearization, width: int) -> FloatArray:
    rows = np.zeros((len(at.curve.point), width))
    if len(rows):
        layout = assembler.layout
        columns = assembler.prepared.curves.columns[at.curve.segment]
        place = (layout.unknown_of_coefficient[columns][:, :, None] + np.arange(3)).reshape(len(rows), -1)
        line = np.arange(len(rows))[:, None]
        size = assembler.orientation_size
        rows[line, 6 * at.curve.image[:, None] + np.arange(size)] = at.curve_jacobian[:, :size]
        np.add.at(rows, (line, place), at.curve_jacobian[:, size:-1])
    return rows


def _linked_parts(at: Linearization, width: int) -> list[FloatArray]:
    """Rows of the chains, their locations eliminated."""
    parts = []
    for window in at.linked_windows:
        kept = window.masked(window.batch.eliminated.kept)
        rows = np.zeros((*kept.shape[:2], width))
        chain, line = np.ogrid[: kept.shape[0], : kept.shape[1]]
        np.add.at(rows, (chain[:, :, None], line[:, :, None], window.unknowns[:, None, :]), kept)
        parts.append(rows.reshape(-1, width))
    return parts


def _point_part(assembler: Assembler, at: Linearization, width: int) -> FloatArray:
    observed, place = assembler.prepared.network.point_observations, assembler.layout.unknown_of_point
    rows = np.zeros((len(observed), 2, width))
    line = np.arange(len(observed))[:, None]
    for axis in range(2):
        rows[line, axis, 6 * observed.image[:, None] + np.arange(6)] = at.points.orientation[:, axis]
        rows[line, axis, place[observed.point]] = at.points.object_xyz[:, axis]
    return rows.reshape(-1, width)


def _distance_part(assembler: Assembler, at: Linearization, width: int) -> FloatArray:
    kept = assembler.kept_points
    rows = np.zeros((len(kept.end_unknowns), width))
    np.add.at(rows, (np.arange(len(rows))[:, None], kept.end_unknowns), kept.end_jacobian(at.distances))
    return rows


def _prior_part(assembler: Assembler, at: Linearization, width: int) -> FloatArray:
    priors = at.orientation_priors
    q, c = np.nonzero(priors.active)
    orientation = np.zeros((len(q), width))
    orientation[np.arange(len(q))[:, None], 6 * priors.image[q][:, None] + np.arange(6)] = priors.jacobian[
        q, c
    ]
    n, d = np.nonzero(assembler.point_inverse_sigma > 0.0)
    points = np.zeros((len(n), width))
    points[np.arange(len(n)), assembler.layout.unknown_of_point[n, d]] = assembler.point_inverse_sigma[n, d]
    return np.vstack([orientation, points])


def _coefficient_part(
    assembler: Assembler, at: Linearization, width: int, chosen: IntArray | None
) -> FloatArray:
    columns, jacobian = assembler.coefficient_rows.columns, at.coefficient_jacobian
    if chosen is not None:
        columns, jacobian = columns[chosen], jacobian[chosen]
    out = np.zeros((len(columns), width))
    if len(columns):
        unknown = assembler.layout.unknown_of_coefficient[columns]
        place = (unknown[:, :, None] + np.arange(3)).reshape(len(columns), -1)
        np.add.at(out, (np.arange(len(columns))[:, None], place), jacobian.reshape(len(columns), -1))
    return out
