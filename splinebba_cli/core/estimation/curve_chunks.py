"""Equations of curve points, some of them at a time: only their Jacobian is kept of all points together.

A point has its equation across the curve, and one along it where that is asked for (where its location is held, it is
one of the equations of the network).  Equations of all points are numbered: across, point by point, then along of the
points that have it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.located_points import Located
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.segment_rows import SegmentRows, rows_on_segments
from splinebba_cli.core.estimation.segment_windows import masked_jacobian
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_points import CurveRows, linearize_curve_points
from splinebba_cli.core.state import State

CHUNK = 8_192  # points at once


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
        chunks = CurveChunks.at(assembler, at.state)
        for begin in range(0, len(along), CHUNK):
            points = np.arange(begin, min(begin + CHUNK, len(along)))
            out.put(chunks.of(points, np.flatnonzero(along[points])))
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
        count = len(chunk.points)
        number = np.concatenate([chunk.points, np.full(len(chunk.point) - count, -1)])
        if len(self.along):
            point = chunk.points[chunk.point[count:]]
            place = np.minimum(np.searchsorted(self.along, point), len(self.along) - 1)
            number[count:] = np.where(self.along[place] == point, len(self.normal) + place, -1)
        self.normal[chunk.points] = chunk.rows.normal
        parts: list[slice | IntArray] = [slice(count)]
        if (number[count:] >= 0).any():
            parts.append(count + np.flatnonzero(number[count:] >= 0))
        for own in parts:
            self.residual[number[own]] = chunk.rows.residual[own]
            self.segment[number[own]] = chunk.segment[own]
            self.jacobian[number[own]] = chunk.jacobian[own]
        return number


@dataclass(frozen=True)
class CurveChunk:
    """Equations of some points."""

    points: IntArray  # (n,) measured points
    point: IntArray  # (k,) the points of the chunk by number: 0 .. n - 1 across, then those along
    image: IntArray  # (k,)
    segment: IntArray  # (k,)
    rows: SegmentRows
    jacobian: FloatArray  # (k, 6 or 0 + 3 w) masked


def along_points(assembler: Assembler, at: Linearization) -> IntArray:
    """Measured points with an equation along the curve that is no part of a chain, ascending."""
    return np.sort(at.held[~assembler.prepared.chains.linked[at.held]])


@dataclass(frozen=True)
class CurveChunks:
    """Equations of the measured points of a state, some of them at a time."""

    assembler: Assembler
    located: Located

    @classmethod
    def at(cls, assembler: Assembler, state: State) -> CurveChunks:
        """All points of the network can be asked for."""
        return cls(assembler, Located.of(assembler.prepared, state))

    def of(self, points: IntArray, along: IntArray) -> CurveChunk:
        """Equations of measured points.

        Parameters
        ----------
        points : (n,) int
        along : (a,) int, places in `points` that get their equation along the curve as well, unless they are linked
        """
        assembler, prepared = self.assembler, self.assembler.prepared
        segment = self.located.segments(points)[0]
        wanted = np.zeros(len(points), dtype=bool)
        wanted[along] = True
        if prepared.curves.any_trigonometric and prepared.curves.trigonometric[segment].any():
            rows = _row_by_row(assembler, self.located.state, points, along)
        else:
            rows = rows_on_segments(prepared, self.located, points, wanted, assembler.orientation_size)
        image, segment = prepared.network.curve_observations.image[points][rows.point], segment[rows.point]
        return CurveChunk(
            points, rows.point, image, segment, rows, self._masked(image, segment, rows.jacobian)
        )

    def _masked(self, image: IntArray, segment: IntArray, jacobian: FloatArray) -> FloatArray:
        """Rows without what belongs to removed unknowns; the same array where nothing is removed."""
        own, images = np.flatnonzero(self._shortened[segment]), self._image_mask
        if images.all() and not len(own):
            return jacobian
        jacobian, size = jacobian.copy(), images.shape[1]
        if not images.all():
            jacobian[:, :size] *= images[image]
        columns = self.assembler.prepared.curves.columns[segment[own]]
        mask = self.assembler.layout.coefficient_mask[columns]
        jacobian[own, size:] *= mask.reshape(len(own), jacobian.shape[1] - size)
        return jacobian

    @property
    def _image_mask(self) -> FloatArray:
        return self.assembler.layout.image_mask[:, : self.assembler.orientation_size]

    @cached_property
    def _shortened(self) -> BoolArray:
        """Segments over coefficients of which some are removed, (S,)."""
        whole = np.asarray(self.assembler.layout.coefficient_mask.all(axis=1))
        return np.asarray(~whole[self.assembler.prepared.curves.columns].all(axis=1))


def _row_by_row(assembler: Assembler, state: State, points: IntArray, along: IntArray) -> SegmentRows:
    """Equations of points where some of the curves are no powers."""
    rows = linearize_curve_points(assembler.prepared, state, points[along], points)
    order = np.argsort(points)
    extra = order[np.searchsorted(points, rows.point[len(points) :], sorter=order)]
    point = np.concatenate([np.arange(len(points)), extra])
    local = rows.weights[:, :, None] * rows.direction[:, None, :]
    orientation = rows.orientation[:, : assembler.orientation_size]
    jacobian = np.concatenate([orientation, local.reshape(len(local), -1)], axis=1)
    return SegmentRows(point, rows.residual, rows.normal, rows.speed, jacobian)


def equation_rows(assembler: Assembler, at: Linearization, numbers: IntArray) -> tuple[CurveRows, FloatArray]:
    """Some equations (q,) of the network and their Jacobian, in the order asked for; no figures of points."""
    count = len(assembler.prepared.network.curve_observations)
    point = np.concatenate([np.arange(count), along_points(assembler, at)])[numbers]
    points, place = np.unique(point, return_inverse=True)
    is_along = numbers >= count
    rows = linearize_curve_points(assembler.prepared, at.state, points[np.unique(place[is_along])], points)
    own = np.where(is_along, len(points) + np.searchsorted(rows.point[len(points) :], point), place)
    jacobian = masked_jacobian(rows, assembler.prepared.curves, assembler.layout, assembler.orientation_size)
    chosen = replace(
        rows, point=point, image=rows.image[own], segment=rows.segment[own], residual=rows.residual[own],
        orientation=rows.orientation[own], weights=rows.weights[own], direction=rows.direction[own],
        along=rows.along[place], speed=rows.speed[place], normal=rows.normal[place],
    )  # fmt: skip
    return chosen, jacobian[own, :-1]


def _other_entries(assembler: Assembler) -> int:
    """Entries that all other rows of a sparse design have at most."""
    network, rows = assembler.prepared.network, assembler.coefficient_rows
    values = 3 * rows.columns.shape[1] * len(rows)
    points = 2 * (6 + 3) * len(network.point_observations) + 3 * len(network.points.ids)
    return int(values + points + 12 * len(network.distances) + 36 * len(network.images.ids))
