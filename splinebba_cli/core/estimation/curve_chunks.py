"""Equations of curve points, some of them at a time: only their Jacobian is kept of all points together.

A point has its equation across the curve, and one along it where that is asked for (where its location is held, it is
one of the equations of the network).  Equations of all points are numbered: across, point by point, then along of the
points that have it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.curve_points import CurveRows, linearize_curve_points
from splinebba_cli.core.state import State

CHUNK = 16_384  # points at once


@dataclass(frozen=True)
class CurveEquations:
    """All equations of curve points."""

    point: IntArray  # (k,) measured point: 0 .. n - 1 across, then those along
    residual: FloatArray  # (k,) whitened
    normal: FloatArray  # (n, 2) whitened unit normal
    segment: IntArray  # (k,)
    width: int  # P = 6 or 0 + 3 w
    entries: FloatArray  # (k P + ...,) Jacobian row by row, then room for the other rows of a sparse design

    @classmethod
    def begun(cls, assembler: Assembler, at: Linearization) -> CurveEquations:
        """Numbered, without figures."""
        count = len(assembler.prepared.network.curve_observations)
        point = np.concatenate([np.arange(count), along_points(assembler, at)])
        width = assembler.orientation_size + 3 * assembler.prepared.curves.support
        entries = np.zeros(len(point) * width + _other_entries(assembler))
        segment = np.zeros(len(point), dtype=np.int64)
        return cls(point, np.zeros(len(point)), np.zeros((count, 2)), segment, width, entries)

    @classmethod
    def at(cls, assembler: Assembler, at: Linearization) -> CurveEquations:
        """All equations of the network."""
        out = cls.begun(assembler, at)
        along = np.zeros(len(out.normal), dtype=bool)
        along[out.along] = True
        for begin in range(0, len(along), CHUNK):
            points = np.arange(begin, min(begin + CHUNK, len(along)))
            out.put(curve_chunk(assembler, at.state, points, np.flatnonzero(along[points])))
        return out

    @cached_property
    def jacobian(self) -> FloatArray:
        """(k, P) masked."""
        return self.entries[: len(self.point) * self.width].reshape(len(self.point), self.width)

    @property
    def along(self) -> IntArray:
        """Points with an equation along the curve."""
        return self.point[len(self.normal) :]

    def put(self, chunk: CurveChunk) -> IntArray:
        """Take the figures of a chunk; the numbers of its rows among all equations, -1 of those that are none."""
        rows, count = chunk.rows, len(chunk.points)
        number = np.full(len(rows.point), -1)
        number[:count] = chunk.points
        point = chunk.points[rows.point[count:]]
        place = np.minimum(np.searchsorted(self.along, point), max(len(self.along) - 1, 0))
        if len(self.along):
            number[count:] = np.where(self.along[place] == point, len(self.normal) + place, -1)
        self.normal[chunk.points] = rows.normal
        own = number >= 0
        for target, values in (
            (self.residual, rows.residual), (self.segment, rows.segment), (self.jacobian, chunk.jacobian),
        ):  # fmt: skip
            target[number[own]] = values[own]
        return number


@dataclass(frozen=True)
class CurveChunk:
    """Equations of some points."""

    points: IntArray  # (n,) measured points
    rows: CurveRows  # (k,) `point` counts the points of the chunk
    jacobian: FloatArray  # (k, 6 or 0 + 3 w) masked


def along_points(assembler: Assembler, at: Linearization) -> IntArray:
    """Measured points with an equation along the curve that is no part of a chain, ascending."""
    return np.sort(at.held[~assembler.prepared.chains.linked[at.held]])


def curve_chunk(assembler: Assembler, state: State, points: IntArray, along: IntArray) -> CurveChunk:
    """Equations of measured points.

    Parameters
    ----------
    points : (n,) int
    along : (a,) int, places in `points` that get their equation along the curve as well, unless they are linked
    """
    prepared, layout = assembler.prepared, assembler.layout
    rows = linearize_curve_points(prepared, state, points[along], points)
    order = np.argsort(points)
    extra = order[np.searchsorted(points, rows.point[len(points) :], sorter=order)]
    rows = replace(rows, point=np.concatenate([np.arange(len(points)), extra]))
    size, support = assembler.orientation_size, prepared.curves.support
    jacobian = np.empty((len(rows.point), size + 3 * support))
    np.multiply(rows.orientation[:, :size], layout.image_mask[rows.image, :size], out=jacobian[:, :size])
    local = jacobian[:, size:].reshape(len(jacobian), support, 3)
    np.multiply(rows.weights[:, :, None], rows.direction[:, None, :], out=local)
    if not layout.coefficient_mask.all():
        local *= layout.coefficient_mask[prepared.curves.columns[rows.segment]]
    return CurveChunk(points, rows, jacobian)


def equation_rows(assembler: Assembler, at: Linearization, numbers: IntArray) -> tuple[CurveRows, FloatArray]:
    """Some equations (q,) of the network and their Jacobian, in the order asked for; no figures of points."""
    count = len(assembler.prepared.network.curve_observations)
    point = np.concatenate([np.arange(count), along_points(assembler, at)])[numbers]
    points, place = np.unique(point, return_inverse=True)
    is_along = numbers >= count
    chunk = curve_chunk(assembler, at.state, points, np.unique(place[is_along]))
    own = np.where(is_along, len(points) + np.searchsorted(chunk.rows.point[len(points) :], place), place)
    rows = chunk.rows
    chosen = replace(
        rows, point=point, image=rows.image[own], segment=rows.segment[own], residual=rows.residual[own],
        orientation=rows.orientation[own], weights=rows.weights[own], direction=rows.direction[own],
        along=rows.along[place], speed=rows.speed[place], normal=rows.normal[place],
    )  # fmt: skip
    return chosen, chunk.jacobian[own]


def _other_entries(assembler: Assembler) -> int:
    """Entries that all other rows of a sparse design have at most."""
    network, rows = assembler.prepared.network, assembler.coefficient_rows
    values = 3 * rows.columns.shape[1] * len(rows)
    points = 2 * (6 + 3) * len(network.point_observations) + 3 * len(network.points.ids)
    return int(values + points + 12 * len(network.distances) + 36 * len(network.images.ids))
