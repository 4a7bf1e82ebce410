"""Measured points in the cells of grids, one grid an image: the points inside a box, without looking at the others.

Cells are numbered row by row through all images and points sorted by cell, so that those of a row of cells are one
range.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray

CELLS = 4  # of a grid at most, for each of its points: others are larger


@dataclass(frozen=True)
class PointGrid:
    """Points sorted by cell."""

    points: IntArray  # (n,)
    starts: IntArray  # (cells + 1,) first place of every cell in `points`
    corner: FloatArray  # (2, m) least x and y of the points of an image
    cell: FloatArray  # (m,) size of the cells
    columns: IntArray  # (m,)
    rows: IntArray  # (m,)
    first: IntArray  # (m,) first cell

    @classmethod
    def of(cls, image: IntArray, xy: FloatArray, size: FloatArray, points: IntArray) -> PointGrid:
        """Grids of some points.

        Parameters
        ----------
        image, xy : (n,), (n, 2) of all points
        size : (m,) of the cells, for every image; made larger where there would be many
        points : (k,) those that are in the grids
        """
        count = len(size)
        own, place = image[points], xy[points].T
        low, high = np.full((2, count), np.inf), np.full((2, count), -np.inf)
        for axis in range(2):
            np.minimum.at(low[axis], own, place[axis])
            np.maximum.at(high[axis], own, place[axis])
        number = np.bincount(own, minlength=count)
        seen = number > 0
        extent = np.where(seen, high - low, 0.0)
        corner = np.where(seen, low, 0.0)
        most = np.maximum(CELLS * number, 1)
        cell = np.maximum(size, np.maximum(np.sqrt(extent[0] * extent[1] / most), extent.max(axis=0) / most))
        cell = np.where(cell > 0.0, cell, 1.0)
        columns, rows = np.floor(extent / cell).astype(np.int64) + 1
        first = np.concatenate([[0], np.cumsum(columns * rows)])
        column, row = np.floor((place - corner[:, own]) / cell[own]).astype(np.int64)
        number_of = first[own] + row * columns[own] + column
        order = np.argsort(number_of, kind="stable")
        starts = np.concatenate([[0], np.cumsum(np.bincount(number_of, minlength=int(first[-1])))])
        return cls(points[order], starts, corner, cell, columns, rows, first[:-1])

    @property
    def frame(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest x and y of the grids, (2, m) each; points may lie on the latter."""
        return self.corner, self.corner + self.cell * np.stack([self.columns, self.rows])

    def ranges(
        self, image: IntArray, low: FloatArray, high: FloatArray
    ) -> tuple[IntArray, IntArray, IntArray]:
        """Places in `points` of those in the cells that boxes touch.

        Parameters
        ----------
        image : (k,)
        low, high : (2, k) corners of boxes

        Returns
        -------
        box, begin, end : (r,) ranges of places; a box may have several
        """
        limit = np.stack([self.columns[image], self.rows[image]])
        cell, corner = self.cell[image], self.corner[:, image]
        with np.errstate(invalid="ignore"):
            lowest = np.clip(np.floor((low - corner) / cell), 0, limit - 1).astype(np.int64)
            highest = np.clip(np.floor((high - corner) / cell), -1, limit - 1).astype(np.int64)
        lowest = np.where((low - corner) / cell >= limit, limit, lowest)
        count = np.where((highest >= lowest).all(axis=0), highest[1] - lowest[1] + 1, 0)
        box = np.repeat(np.arange(len(image)), count)
        row = lowest[1, box] + np.arange(len(box)) - np.repeat(np.cumsum(count) - count, count)
        base = self.first[image[box]] + row * limit[0, box]
        begin, end = self.starts[base + lowest[0, box]], self.starts[base + highest[0, box] + 1]
        filled = end > begin
        return box[filled], begin[filled], end[filled]


def expand(begin: IntArray, end: IntArray) -> tuple[IntArray, IntArray]:
    """Which range, and the number, of all numbers begin <= n < end of ranges, (k,) each."""
    count = end - begin
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) + np.repeat(begin - (np.cumsum(count) - count), count)
