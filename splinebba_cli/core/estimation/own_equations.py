"""The equations of single features and images, as small dense matrices with the locations eliminated.

    a curve    its image points, arc lengths, tangents, given values and shape conditions
               over its coefficients and the orientations of the images that see it
    a point    its rays and given coordinates over its coordinates and the same orientations
    an image   everything that is measured in it, and its priors, over its six orientation unknowns

Features of the same numbers of unknowns and images go together, as stacks of matrices with zero rows where they have
fewer equations than others.  Removed unknowns keep zero columns.  Every elimination of a location is orthogonal and
takes exactly one from the equations, the unknowns and the rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.linked_points import LinkedBatch


@dataclass(frozen=True)
class Owned:
    """Numbers of rows by their owner: those of owner k are order[starts[k] : starts[k + 1]]."""

    order: IntArray
    starts: IntArray  # (owners + 1,)

    @classmethod
    def of(cls, owner: IntArray, count: int) -> Owned:
        """Rows (n,) of every owner, ascending."""
        order = np.argsort(owner, kind="stable")
        return cls(order, np.searchsorted(owner[order], np.arange(count + 1)))

    @property
    def counts(self) -> IntArray:
        """Numbers of rows, (owners,)."""
        return np.diff(self.starts)

    def rows(self, owners: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Rows of some owners, the number of its owner among them and that of the row in its owner, (k,) each."""
        number = self.counts[owners]
        within = np.arange(int(number.sum())) - np.repeat(np.cumsum(number) - number, number)
        return (
            self.order[np.repeat(self.starts[owners], number) + within],
            np.repeat(np.arange(len(owners)), number),
            within,
        )


@dataclass(frozen=True)
class _Window:
    """Chains of a batch, their locations eliminated, by curve."""

    batch: LinkedBatch
    kept: FloatArray  # (G, R, P) masked
    of_curve: Owned


@dataclass(frozen=True)
class OwnEquations:
    """Equations of a linearised network by their owner."""

    assembler: Assembler
    at: Linearization

    @cached_property
    def coefficient_counts(self) -> IntArray:
        """Number of coefficients of every curve, (nc,)."""
        return np.asarray(np.diff(self.assembler.prepared.curves.coefficient_start))

    @cached_property
    def image_counts(self) -> IntArray:
        """Number of images that see every curve, (nc,)."""
        return np.bincount(self._seen // self._images, minlength=len(self.coefficient_counts))

    @cached_property
    def row_counts(self) -> IntArray:
        """Number of rows of every curve's matrix, (nc,)."""
        counts = self._rows_of_curve.counts + self._values_of_curve.counts
        for window in self._windows:
            counts = counts + window.of_curve.counts * window.kept.shape[1]
        return counts

    def of_curves(self, curves: IntArray) -> FloatArray:
        """All equations of curves with c coefficients in m images each, (g, rows, 3 c + 6 m)."""
        width = 3 * int(self.coefficient_counts[curves[0]]) + 6 * int(self.image_counts[curves[0]])
        out = np.zeros((len(curves), int(self.row_counts[curves].max(initial=0)), width))
        begin = np.zeros(len(curves), dtype=np.int64)  # rows that are filled
        self._put_points(out, curves, begin)
        begin = begin + self._rows_of_curve.counts[curves]
        for window in self._windows:
            self._put_chains(out, window, curves, begin)
            begin = begin + window.of_curve.counts[curves] * window.kept.shape[1]
        self._put_values(out, curves, begin)
        return out

    def of_points(self, points: IntArray) -> FloatArray:
        """Rays and given coordinates of object points with m rays each, (g, 2 m + 3, 3 + 6 m)."""
        at, layout = self.at, self.assembler.layout
        count = int(self.rays_of_point.counts[points[0]])
        rays = self.rays_of_point.rows(points)[0].reshape(len(points), count)
        image = self.assembler.prepared.network.point_observations.image[rays]
        out = np.zeros((len(points), 2 * count + 3, 3 + 6 * count))
        out[:, : 2 * count, :3] = (
            at.points.object_xyz[rays] * layout.point_mask[points][:, None, None]
        ).reshape(len(points), 2 * count, 3)
        orientation = at.points.orientation[rays] * layout.image_mask[image][:, :, None]
        for ray in range(count):
            first = 3 + 6 * ray
            out[:, 2 * ray : 2 * ray + 2, first : first + 6] = orientation[:, ray]
        each = np.arange(3)
        out[:, 2 * count + each, each] = self.assembler.point_inverse_sigma[points]
        return out

    def of_images(self) -> tuple[FloatArray, Owned]:
        """Equations of all images over their orientations, features known: rows (k, 6), and those of every image."""
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
        return matrix * layout.image_mask[image], Owned.of(image, layout.image_count)

    @cached_property
    def tracks(self) -> tuple[IntArray, Owned]:
        """Curves of all pairs of a curve and an image that sees it, sorted by curve, and their measured points."""
        return self._seen // self._images, Owned.of(self._track_of_point, len(self._seen))

    def across(self, tracks: IntArray) -> FloatArray:
        """Equations across curves in single images, over *all* of their coefficients, held ones too, (g, k, 3 c).

        All the curves have c coefficients; a track is one curve in one image.
        """
        prepared, rows = self.assembler.prepared, self.at.curve
        of_track, points = self.tracks
        point, place, line = points.rows(tracks)  # the first rows, one a point, are those across
        curves = of_track[tracks]
        out = np.zeros(
            (len(tracks), int(points.counts[tracks].max()), 3 * int(self.coefficient_counts[curves[0]]))
        )
        local = rows.weights[point, :, None] * rows.direction[point, None, :]
        columns = self._places(curves[place], prepared.curves.columns[rows.segment[point]])
        np.add.at(out, (place[:, None], line[:, None], columns), local.reshape(len(point), columns.shape[1]))
        return out

    @cached_property
    def rays_of_point(self) -> Owned:
        """Image points of every object point."""
        network = self.assembler.prepared.network
        return Owned.of(network.point_observations.point, len(network.points.ids))

    @property
    def _images(self) -> int:
        return max(self.assembler.layout.image_count, 1)

    @cached_property
    def _pair_of_point(self) -> IntArray:
        observed = self.assembler.prepared.network.curve_observations
        return np.asarray(observed.curve * self._images + observed.image)

    @cached_property
    def _seen(self) -> IntArray:
        """Pairs curve * m + image of what sees what, ascending."""
        return np.unique(self._pair_of_point)

    @cached_property
    def _track_of_point(self) -> IntArray:
        return np.searchsorted(self._seen, self._pair_of_point)

    @cached_property
    def _windows(self) -> list[_Window]:
        curve = self.assembler.prepared.network.curve_observations.curve
        return [
            _Window(
                window.batch,
                window.masked(window.batch.eliminated.kept),
                Owned.of(curve[window.batch.chains.points[:, 0]], len(self.coefficient_counts)),
            )
            for window in self.at.linked_windows
        ]

    @cached_property
    def _rows_of_curve(self) -> Owned:
        observed = self.assembler.prepared.network.curve_observations
        return Owned.of(observed.curve[self.at.curve.point], len(self.coefficient_counts))

    @cached_property
    def _values_of_curve(self) -> Owned:
        return Owned.of(self.assembler.coefficient_rows.curve, len(self.coefficient_counts))

    def _places(self, curves: IntArray, columns: IntArray) -> IntArray:
        """Columns (rows, 3 w) of coefficients (rows, w) in the matrices of their curves (rows,)."""
        own = columns - self.assembler.prepared.curves.coefficient_start[curves][:, None]
        return np.asarray((3 * own[:, :, None] + np.arange(3)).reshape(len(own), 3 * columns.shape[1]))

    def _image_places(self, curves: IntArray, image: IntArray) -> IntArray:
        """Columns (rows, 6 or 0) of the orientations of images (rows,) in the matrices of curves (rows,)."""
        first = np.searchsorted(self._seen, curves * self._images)
        number = np.searchsorted(self._seen, curves * self._images + image) - first
        begin = 3 * self.coefficient_counts[curves] + 6 * number
        return np.asarray(begin[:, None] + np.arange(self.assembler.orientation_size))

    def _put_points(self, out: FloatArray, curves: IntArray, begin: IntArray) -> None:
        row, place, line = self._rows_of_curve.rows(curves)
        rows, size, of = self.at.curve, self.assembler.orientation_size, curves[place]
        at = place[:, None], (begin[place] + line)[:, None]
        columns = self._places(of, self.assembler.prepared.curves.columns[rows.segment[row]])
        np.add.at(out, (*at, columns), self.at.curve_jacobian[row, size:-1])
        out[(*at, self._image_places(of, rows.image[row]))] = self.at.curve_jacobian[row, :size]

    def _put_chains(self, out: FloatArray, window: _Window, curves: IntArray, begin: IntArray) -> None:
        chain, place, number = window.of_curve.rows(curves)
        height, size = window.kept.shape[1], self.assembler.orientation_size
        line = (begin[place] + height * number)[:, None] + np.arange(height)
        at = place[:, None, None], line[:, :, None]
        columns = self._places(curves[place], window.batch.columns[chain])
        np.add.at(out, (*at, columns[:, None]), window.kept[chain, :, size:])
        images = self._image_places(curves[place], window.batch.image[chain])
        out[(*at, images[:, None])] = window.kept[chain, :, :size]

    def _put_values(self, out: FloatArray, curves: IntArray, begin: IntArray) -> None:
        row, place, line = self._values_of_curve.rows(curves)
        columns = self.assembler.coefficient_rows.columns[row]
        jacobian = self.at.coefficient_jacobian[row] * self.assembler.layout.coefficient_mask[columns]
        np.add.at(
            out,
            (place[:, None], (begin[place] + line)[:, None], self._places(curves[place], columns)),
            jacobian.reshape(len(row), 3 * columns.shape[1]),
        )
