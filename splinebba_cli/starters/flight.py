"""A flight over lines: two strips along their main direction, planned so that both together see all of them.

    F across the strips:  1.6 F = W + margin  (side overlap 40 %),   forward overlap 60 %

with the extent W of the lines across their main direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, Role
from splinebba_cli.simulation.block_geometry import BlockGeometry
from splinebba_cli.simulation.feature_geometry import PointFeatures
from splinebba_cli.starters.digital_camera import DigitalCamera

FORWARD, SIDE = 0.6, 0.4  # overlaps
LONGEST_STRIP = 8.0  # length of the lines in footprints across the strip, at most
MARGIN = 0.15  # of the footprint, at either side
TIES_PER_IMAGE, CHECKS = 5, 6


@dataclass(frozen=True)
class Extent:
    """Main direction and extent of lines in plan."""

    centre: FloatArray  # (2,)
    axes: FloatArray  # (2, 2) rows: along, across
    length: float
    width: float

    @classmethod
    def of(cls, xyz: FloatArray) -> Extent:
        """Of points (n, 3)."""
        mean = xyz[:, :2].mean(axis=0)
        _, _, axes = np.linalg.svd(xyz[:, :2] - mean, full_matrices=False)
        axes[0] *= np.copysign(1.0, axes[0, 0])  # a rule for the sign, which the decomposition leaves open
        axes[1] = [-axes[0, 1], axes[0, 0]]
        along = (xyz[:, :2] - mean) @ axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        centre = mean + 0.5 * (low + high) @ axes
        return cls(centre, axes, float(high[0] - low[0]), float(high[1] - low[1]))

    def plan(self, along: FloatArray, across: FloatArray) -> FloatArray:
        """X and Y (n, 2) of places along and across the main direction, metres from the centre."""
        return np.asarray(self.centre + np.column_stack([along, across]) @ self.axes)


@dataclass(frozen=True)
class Flight:
    """A planned block over lines."""

    block: BlockGeometry
    image_ids: tuple[str, ...]
    extent: Extent
    height_m: float  # above the mean height of the lines
    footprint_m: tuple[float, float]  # along, across


def plan_flight(xyz: FloatArray, camera: DigitalCamera, origin: FloatArray) -> Flight:
    """Two strips over lines.

    Parameters
    ----------
    xyz : (n, 3) float, metres, local frame
        Points of all lines, not all of them above each other.
    origin : (3,) float, metres
        Of the local frame.
    """
    extent = Extent.of(xyz)
    width_mm, height_mm = camera.planned_format_mm()
    across = max(extent.width / (2.0 - SIDE - 2.0 * MARGIN), extent.length / LONGEST_STRIP)
    height = across * camera.principal_distance_mm / height_mm
    along = across * width_mm / height_mm
    base = (1.0 - FORWARD) * along
    count = max(3, math.ceil(extent.length / base) + 1)
    stations: FloatArray = base * (np.arange(count, dtype=np.float64) - 0.5 * (count - 1))
    offset = 0.5 * (1.0 - SIDE) * across
    places = [
        extent.plan(stations, np.full(count, -offset)),
        extent.plan(stations[::-1], np.full(count, offset)),
    ]
    heading = math.atan2(extent.axes[0, 1], extent.axes[0, 0])
    generator = np.random.default_rng(5)
    eop: FloatArray = np.empty((2 * count, 6))
    eop[:, :3] = generator.normal(0.0, np.radians(1.0), (2 * count, 3))
    eop[:, 2] += np.repeat([heading, heading + math.pi], count)
    eop[:, 3:5] = np.vstack(places)
    eop[:, 5] = xyz[:, 2].mean() + height
    eop[:, 3:] += generator.normal(0.0, 0.005 * height, (2 * count, 3))
    ids = tuple(f"{strip}{number:02d}" for strip in ("01", "02") for number in range(1, count + 1))
    block = BlockGeometry(eop, camera.principal_distance_mm, camera.planned_format_mm(), origin)
    return Flight(block, ids, extent, height, (along, across))


def points_below(flight: Flight, xyz: FloatArray, check_sigma_m: float) -> PointFeatures:
    """Tie and check points under a flight, at the heights of the nearest knots and somewhat off them.

    Parameters
    ----------
    xyz : (n, 3) float, metres
        Knots of the lines.
    """
    generator = np.random.default_rng(7)
    count = TIES_PER_IMAGE * len(flight.image_ids) + CHECKS
    half_length = 0.5 * flight.extent.length + 0.2 * flight.footprint_m[0]
    half_width = (0.5 * (1.0 - SIDE) + 0.4) * flight.footprint_m[1]
    along, across = generator.uniform(-1.0, 1.0, (2, count)) * np.array([[half_length], [half_width]])
    along[:CHECKS] *= 0.8
    across[:CHECKS] *= 0.3  # check points lie well inside, where many images see them
    xy = flight.extent.plan(along, across)
    nearest = np.argmin(((xy[:, None] - xyz[None, :, :2]) ** 2).sum(axis=2), axis=1)
    z = xyz[nearest, 2] + generator.uniform(-0.01, 0.01, count) * flight.height_m
    kinds: tuple[tuple[Role, int], ...] = (("check", CHECKS), ("tie", count - CHECKS))
    ids = tuple(f"{name}-{k + 1}" for name, number in kinds for k in range(number))
    role = tuple(name for name, number in kinds for _ in range(number))
    sigma = np.where(np.array(role)[:, None] == "check", check_sigma_m, np.inf) * np.ones(3)
    return PointFeatures(ids, role, np.column_stack([xy, z]), sigma)
