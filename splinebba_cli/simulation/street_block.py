"""A street as a drone sees it: kerbs that are known, edges and a pool that are not, six images in two strips."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.block_geometry import BlockGeometry
from splinebba_cli.simulation.feature_geometry import Feature, control_spline, road, shore, tie_spline

PIXEL_MM = 0.01  # noise of 5 µm is half a pixel


def street_images() -> BlockGeometry:
    """Two strips of three images, 55 m above ground: 64 % forward, 45 % side overlap, c = 36 mm, 5400 x 3600 pixels."""
    generator = np.random.default_rng(61)
    x, y = np.array([-22.0, -22.0, -22.0, 22.0, 22.0, 22.0]), np.array([-20.0, 0.0, 20.0, 20.0, 0.0, -20.0])
    eop = np.empty((6, 6))
    eop[:, :3] = generator.normal(0.0, np.radians(2.0), (6, 3))
    eop[3:, 2] += np.pi
    eop[:, 3:] = generator.normal(0.0, 0.8, (6, 3)) + np.column_stack([x, y, np.full(6, 55.0)])
    return BlockGeometry(eop, 36.0, (54.0, 36.0), np.zeros(3), PIXEL_MM)


def street_features() -> tuple[Feature, ...]:
    """Eight kerbs that are control, three edges and a closed one that are ties."""
    kerbs = (
        ((-62.0, -7.0), (62.0, -5.0), 11, 1.2),
        ((-62.0, 0.5), (62.0, 2.5), 11, -1.0),
        ((-62.0, 30.0), (62.0, 33.0), 11, 1.5),
        ((-62.0, -35.0), (62.0, -31.0), 11, -1.5),
        ((-6.0, -46.0), (-3.0, 46.0), 9, 1.2),
        ((3.0, -46.0), (5.0, 46.0), 9, -1.0),
        ((-40.0, -46.0), (-36.0, 46.0), 9, -1.6),
        ((37.0, -46.0), (41.0, 46.0), 9, 1.4),
    )
    control = [
        control_spline(f"kerb-{number}", _on_ground(road(*kerb)))
        for number, kerb in enumerate(kerbs, start=1)
    ]
    ties = [
        tie_spline("path", _on_ground(road((-32.0, -28.0), (-10.0, -12.0), 6, 1.5))),
        tie_spline("roof", _on_ground(road((10.0, 8.0), (33.0, 25.0), 6, -1.2), 5.0)),
        tie_spline("wall", _on_ground(road((-32.0, 24.0), (-10.0, 9.0), 6, 1.4), 2.0)),
        tie_spline("pool", _on_ground(shore((20.0, -19.0), 7.0, 8)), closed=True),
    ]
    return (*control, *ties)


def _on_ground(knots: FloatArray, above_m: float = 0.0) -> FloatArray:
    """Knots at a height above a gently rolling ground."""
    x, y = knots[:, 0], knots[:, 1]
    height = 1.6 * np.sin(x / 23.0) * np.cos(y / 19.0) + 0.9 * np.sin(x / 11.0 + y / 14.0)
    return np.column_stack([x, y, height + above_m])
