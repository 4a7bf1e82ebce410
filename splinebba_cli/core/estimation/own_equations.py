"""The equations of single features and images, as small dense matrices with the locations eliminated.

    a curve    its image points, arc lengths, tangents, given values and shape conditions
               over its coefficients and the orientations of the images that see it
    a point    its rays and given coordinates over its coordinates and the same orientations
    an image   everything that is measured in it, and its priors, over its six orientation unknowns

Removed unknowns keep zero columns.  Every elimination of a location is orthogonal and takes exactly one from the
equations, the unknowns and the rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.linked_points import LinkedBatch


@dataclass(frozen=True)
class OwnMatrix:
    """Equations of one feature."""

    unknowns: FloatArray  # (rows, p) coefficients or coordinates
    orientations: FloatArray  # (rows, 6 m) of the images that see it


@dataclass(frozen=True)
class _Window:
    """Chains of a batch, their locations eliminated, by curve."""

    batch: LinkedBatch
    kept: FloatArray  # (G, R, P) masked
    of_curve: list[IntArray]


@dataclass(frozen=True)
class OwnEquations:
    """Equations of a linearised network by their owner."""

    assembler: Assembler
    at: Linearization

    def curve_size(self, curve: int) -> tuple[int, int]:
        """Upper bound of the rows and number of columns of one curve's matrix."""
        seen = len(np.unique(self._observed_image[self._points_of_curve[curve]]))
        starts = self.assembler.prepared.curves.coefficient_start
        columns = 3 * int(starts[curve + 1] - starts[curve]) + 6 * seen
        return 3 * len(self._points_of_curve[curve]) + columns, columns

    def of_curve(self, curve: int) -> OwnMatrix:
        """All equations of one curve."""
        images = np.unique(self._observed_image[self._points_of_curve[curve]])
        parts = [self._curve_points(curve, images)]
        parts += [self._chains(k, curve, images) for k in range(len(self._windows))]
        parts.append(self._coefficient_rows(curve, images))
        matrix = np.vstack(parts)
        size = self._coefficients(curve)
        return OwnMatrix(matrix[:, :size], matrix[:, size:])

    def of_point(self, point: int) -> OwnMatrix:
        """Rays and given coordinates of one object point."""
        rays, at = self._rays_of_point[point], self.at
        mask = self.assembler.layout.point_mask[point]
        image = self.assembler.prepared.network.point_observations.image[rays]
        unknowns = (at.points.object_xyz[rays] * mask).reshape(-1, 3)
        orientations = np.zeros((len(rays), 2, len(rays), 6))
        each = np.arange(len(rays))
        orientations[each, :, each] = (
            at.points.orientation[rays] * self.assembler.layout.image_mask[image][:, None]
        )
        given = np.diag(self.assembler.point_inverse_sigma[point])
        return OwnMatrix(
            np.vstack([unknowns, given]),
            np.vstack([orientations.reshape(2 * len(rays), -1), np.zeros((3, 6 * len(rays)))]),
        )

    def of_images(self) -> list[FloatArray]:
        """Equations of every image over its orientation, features known, (rows, 6) each."""
        at, layout = self.at, self.assembler.layout
        points = self.assembler.prepared.network.point_observations
        size = self.assembler.orientation_size
        owner = [points.image.repeat(2), at.orientation_priors.image.repeat(6)]
        rows = [at.points.orientation.reshape(-1, 6), at.orientation_priors.jacobian.reshape(-1, 6)]
        if size:
            owner.append(at.curve.image)
            rows.append(at.curve_jacobian[:, :size])
            for window in at.linked_windows:
                kept = window.masked(window.batch.eliminated.kept)[:, :, :size]
                owner.append(window.batch.image.repeat(kept.shape[1]))
                rows.append(kept.reshape(-1, size))
        image, matrix = np.concatenate(owner), np.concatenate(rows)
        matrix = matrix * layout.image_mask[image]
        order = np.argsort(image, kind="stable")
        bounds = np.searchsorted(image[order], np.arange(1, layout.image_count))
        return np.split(matrix[order], bounds)

    def across(self, curve: int) -> list[FloatArray]:
        """Equations across a curve, image by image, over *all* of its coefficients, held ones too: (points, 3 c)."""
        prepared, rows = self.assembler.prepared, self.at.curve
        points = self._points_of_curve[curve]  # the first rows, one a point, are those across
        if not len(points):
            return []
        local = rows.weights[points, :, None] * rows.direction[points, None, :]
        matrix = np.zeros((len(points), self._coefficients(curve)))
        place = self._coefficient_places(curve, prepared.curves.columns[rows.segment[points]])
        np.add.at(matrix, (np.arange(len(points))[:, None], place), local.reshape(len(points), -1))
        return [matrix[rows.image[points] == image] for image in np.unique(rows.image[points])]

    @property
    def _observed_image(self) -> IntArray:
        return self.assembler.prepared.network.curve_observations.image

    @cached_property
    def _windows(self) -> list[_Window]:
        network = self.assembler.prepared.network
        curve = network.curve_observations.curve
        return [
            _Window(
                window.batch,
                window.masked(window.batch.eliminated.kept),
                _by_owner(curve[window.batch.chains.points[:, 0]], len(network.curves)),
            )
            for window in self.at.linked_windows
        ]

    @cached_property
    def _points_of_curve(self) -> list[IntArray]:
        network = self.assembler.prepared.network
        return _by_owner(network.curve_observations.curve, len(network.curves))

    @cached_property
    def _rows_of_curve(self) -> list[IntArray]:
        network = self.assembler.prepared.network
        return _by_owner(network.curve_observations.curve[self.at.curve.point], len(network.curves))

    @cached_property
    def _rays_of_point(self) -> list[IntArray]:
        network = self.assembler.prepared.network
        return _by_owner(network.point_observations.point, len(network.points.ids))

    @cached_property
    def _values_of_curve(self) -> list[IntArray]:
        return _by_owner(self.assembler.coefficient_rows.curve, len(self.assembler.prepared.network.curves))

    def _coefficients(self, curve: int) -> int:
        starts = self.assembler.prepared.curves.coefficient_start
        return 3 * int(starts[curve + 1] - starts[curve])

    def _coefficient_places(self, curve: int, columns: IntArray) -> IntArray:
        """Columns (rows, 3 w) of coefficients (rows, w) in the matrix of their curve."""
        own = columns - int(self.assembler.prepared.curves.coefficient_start[curve])
        return np.asarray((3 * own[:, :, None] + np.arange(3)).reshape(len(own), 3 * columns.shape[1]))

    def _empty(self, curve: int, rows: int, images: IntArray) -> FloatArray:
        return np.zeros((rows, self._coefficients(curve) + 6 * len(images)))

    def _curve_points(self, curve: int, images: IntArray) -> FloatArray:
        chosen = self._rows_of_curve[curve]
        rows, size = self.at.curve, self.assembler.orientation_size
        matrix = self._empty(curve, len(chosen), images)
        line = np.arange(len(chosen))[:, None]
        place = self._coefficient_places(curve, self.assembler.prepared.curves.columns[rows.segment[chosen]])
        np.add.at(matrix, (line, place), self.at.curve_jacobian[chosen, size:-1])
        first = self._coefficients(curve) + 6 * np.searchsorted(images, rows.image[chosen])
        matrix[line, first[:, None] + np.arange(size)] = self.at.curve_jacobian[chosen, :size]
        return matrix

    def _chains(self, number: int, curve: int, images: IntArray) -> FloatArray:
        window, size = self._windows[number], self.assembler.orientation_size
        chosen = window.of_curve[curve]
        kept = window.kept[chosen]
        matrix = self._empty(curve, kept.shape[0] * kept.shape[1], images)
        chain = np.repeat(np.arange(len(chosen)), kept.shape[1])
        flat, line = kept.reshape(len(chain), kept.shape[2]), np.arange(len(chain))[:, None]
        place = self._coefficient_places(curve, window.batch.columns[chosen])[chain]
        np.add.at(matrix, (line, place), flat[:, size:])
        first = self._coefficients(curve) + 6 * np.searchsorted(images, window.batch.image[chosen])[chain]
        matrix[line, first[:, None] + np.arange(size)] = flat[:, :size]
        return matrix

    def _coefficient_rows(self, curve: int, images: IntArray) -> FloatArray:
        chosen = self._values_of_curve[curve]
        columns = self.assembler.coefficient_rows.columns[chosen]
        jacobian = self.at.coefficient_jacobian[chosen] * self.assembler.layout.coefficient_mask[columns]
        matrix = self._empty(curve, len(chosen), images)
        line = np.arange(len(chosen))[:, None]
        np.add.at(
            matrix,
            (line, self._coefficient_places(curve, columns)),
            jacobian.reshape(len(chosen), 3 * columns.shape[1]),
        )
        return matrix


def _by_owner(owner: IntArray, count: int) -> list[IntArray]:
    """Numbers of the members of every owner."""
    order = np.argsort(owner, kind="stable")
    return np.split(order, np.searchsorted(owner[order], np.arange(1, max(count, 1))))[:count]
