"""Points of a chunk as their images see them, and their rows over the unknowns of their windows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.curve_windows import Chunk, CurveWindows
from splinebba_cli.core.estimation.located_points import Located
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.curve_point_rows import object_rows, orientation_rows
from splinebba_cli.core.observations.photo_polynomials import (
    CurvePlaces,
    photo_polynomials,
    places_on_segments,
)
from splinebba_cli.core.state import Prepared


@dataclass(frozen=True)
class SeenPoints:
    """Points of a chunk as their images see them."""

    places: CurvePlaces
    weights: FloatArray  # (b, n) of the coefficients of the block
    rotation: FloatArray  # (3, 3, n)
    distance: FloatArray  # (n,) principal distances

    @classmethod
    def of(
        cls, windows: CurveWindows, blocks: CurveBlocks, prepared: Prepared, at: Located, chunk: Chunk
    ) -> SeenPoints:
        """All points of a chunk."""
        image, block = windows.image[chunk.windows], windows.block[chunk.windows]
        number = windows.points[chunk.points]
        window = windows.window[chunk.points] - chunk.windows.start
        first, count = blocks.first_segment[block], blocks.segment_count[block]
        longest = int(count.max())
        segments = first[:, None] + np.minimum(np.arange(longest), count[:, None] - 1)
        distance = prepared.principal_distance
        table = photo_polynomials(at.polynomials, distance, at.state, image, segments)
        segment, t = at.segments(number)
        places = places_on_segments(table, window * longest + segment - first[window], t)
        powers = blocks.powers(int(blocks.count[block[0]]))
        a = np.take(powers, segment, axis=2, mode="clip")
        weights = t * a[3]
        for k in (2, 1, 0):
            weights += a[k]
            if k:
                weights *= t
        rotation = np.take(at.state.rotation[image].transpose(1, 2, 0), window, axis=2)
        return cls(places, weights, rotation, distance[image][window])

    def __getitem__(self, points: IntArray) -> SeenPoints:
        places = CurvePlaces(
            self.places.value[:, points], self.places.first[:, points], self.places.second[:, points]
        )
        return SeenPoints(places, self.weights[:, points], self.rotation[:, :, points], self.distance[points])

    def rows(self, h: FloatArray, residual: FloatArray, orientation_size: int) -> FloatArray:
        """Derivatives over orientation and coefficients and the residual, (P + 1, n).

        Parameters
        ----------
        h : (3, n) d/dp, p scaled as in the tables
        """
        size, count = orientation_size, len(self.weights)
        rows = np.empty((size + 3 * count + 1, len(residual)))
        h[:2] *= -self.distance
        g = rows[3:6] if size else np.empty((3, len(residual)))
        object_rows(h, self.rotation, g)
        np.multiply(self.weights[:, None], g, out=rows[size:-1].reshape(count, 3, -1))
        if size:
            p = self.places.value.copy()
            p[:2] /= -self.distance
            orientation_rows(h, p, rows[:3])
            np.negative(g, out=g)
        rows[-1] = residual
        return rows
