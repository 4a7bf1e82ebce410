"""A railway-like alignment: straights, clothoids and circular arcs, with grades and parabolic vertical curves.

Curvature and slope are piecewise linear along the alignment,

    x'(s) = cos θ,  y'(s) = sin θ,  θ' = κ(s),  z'(s) = g(s)

integrated by Gauss–Legendre quadrature between all places where κ breaks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray

RADII = (400.0, 500.0, 700.0, 1000.0, 1500.0, 2500.0)  # metres
TRANSITION = 60_000.0  # radius times length of a clothoid, m²
GRADE_EVERY, VERTICAL_CURVE = 1000.0, 300.0  # metres
STEEPEST = 0.012


@dataclass(frozen=True)
class Alignment:
    """Curvature (1/m) and slope at stations (m), linear between them."""

    curvature_station: FloatArray
    curvature: FloatArray
    slope_station: FloatArray
    slope: FloatArray

    def points(self, station: FloatArray) -> FloatArray:
        """Points at ascending stations, (n, 3) metres; the first station of the alignment is (0, 0, 100)."""
        joints = np.concatenate([[0.0], self.curvature_station, self.slope_station, station])
        grid = np.unique(joints[joints <= station[-1]])
        nodes, weights = np.polynomial.legendre.leggauss(8)
        half = 0.5 * np.diff(grid)
        inside = 0.5 * (grid[:-1] + grid[1:])[:, None] + half[:, None] * nodes
        heading = self._integral(self.curvature_station, self.curvature, inside)
        steps = [half * (f(heading) @ weights) for f in (np.cos, np.sin)]
        plan = np.vstack([[0.0, 0.0], np.cumsum(np.stack(steps, axis=1), axis=0)])
        height = 100.0 + self._integral(self.slope_station, self.slope, station)
        return np.column_stack([plan[np.searchsorted(grid, station)], height])

    @staticmethod
    def _integral(station: FloatArray, value: FloatArray, at: FloatArray) -> FloatArray:
        """Integral from the first station of a piecewise linear function."""
        length = np.diff(station)
        area = np.concatenate([[0.0], np.cumsum(0.5 * (value[:-1] + value[1:]) * length)])
        piece = np.clip(np.searchsorted(station, at, side="right") - 1, 0, len(length) - 1)
        d = at - station[piece]
        rate = (value[piece + 1] - value[piece]) / length[piece]
        return np.asarray(area[piece] + value[piece] * d + 0.5 * rate * d * d)


def random_alignment(length: float, seed: int = 0) -> Alignment:
    """Straight, clothoid, arc, clothoid, again and again, at least `length` metres."""
    generator = np.random.default_rng(seed)
    station, curvature = [0.0], [0.0]
    while station[-1] < length:
        radius = float(generator.choice(RADII))
        bend = float(generator.choice((-1.0, 1.0))) / radius
        clothoid = float(np.clip(TRANSITION / radius, 40.0, 150.0))
        for part, value in (
            (generator.uniform(200.0, 1200.0), 0.0),
            (clothoid, bend),
            (generator.uniform(100.0, 500.0), bend),
            (clothoid, 0.0),
        ):
            station.append(station[-1] + float(part))
            curvature.append(value)
    starts = np.arange(0.0, length + 2.0 * GRADE_EVERY, GRADE_EVERY)
    grades = generator.uniform(-STEEPEST, STEEPEST, len(starts))
    return Alignment(
        curvature_station=np.array(station),
        curvature=np.array(curvature),
        slope_station=np.stack([starts, starts + GRADE_EVERY - VERTICAL_CURVE], axis=1).ravel(),
        slope=np.repeat(grades, 2),
    )


def digitised(alignment: Alignment, length: float, step: float, noise: float, seed: int = 1) -> FloatArray:
    """Points every `step` metres with normal noise of σ `noise` in x, y and z, (n, 3) metres."""
    points = alignment.points(np.arange(0.0, length + 0.5 * step, step))
    return points + noise * np.random.default_rng(seed).normal(size=points.shape)
