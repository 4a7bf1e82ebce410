"""Few curves before few cameras, traced without noise or with it."""

from __future__ import annotations

import numpy as np

from benchmarks.chain_block import HEIGHT_M, ChainBlock, seen_block
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import FloatArray

CORNERS = np.array([[-150.0, -100.0], [150.0, -100.0], [-150.0, 100.0], [150.0, 100.0]])
IN_LINE = np.array([[-240.0, 0.0], [-80.0, 0.0], [80.0, 0.0], [240.0, 0.0]])
STEP_M = 1.5  # 25 pixels of 6 cm


def vertical_views(ground: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nearly vertical images above points of the ground, rotations and positions."""
    position = np.column_stack([ground, np.full(len(ground), HEIGHT_M)])
    angles = np.array([[0.01 * (k % 3 - 1), 0.01 * ((k + 1) % 3 - 1), 0.3 * k] for k in range(len(ground))])
    return rotation_object_from_photo(angles), position


def scene(
    curves: list[FloatArray],
    ground: FloatArray = CORNERS,
    sigma_px: float = 0.5,
    seed: int = 1,
    lost: tuple[float, float] = (0.0, 0.0),
) -> ChainBlock:
    """Curves, given by points along them (k, 3), in four images."""
    rotation, position = vertical_views(ground)
    return seen_block(same_length(curves), rotation, position, sigma_px, np.random.default_rng(seed), lost)


def straight(
    start: tuple[float, float, float], along: tuple[float, float, float], count: int = 40
) -> FloatArray:
    """Points every six metres of a straight line, (count, 3)."""
    direction = np.array(along) / np.linalg.norm(along)
    return np.array(start) + STEP_M * np.arange(count)[:, None] * direction


def arc(radius: float, turn: float, height: float = 10.0) -> FloatArray:
    """Points every one and a half metres of an arc about the origin that rises and falls a little, (count, 3)."""
    angle = np.linspace(0.0, turn, round(radius * turn / STEP_M) + 1)
    return np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), height + 5.0 * np.sin(2.0 * angle)]
    )


def same_length(curves: list[FloatArray]) -> FloatArray:
    """Curves cut to the number of points of the shortest, (c, k, 3)."""
    count = min(map(len, curves))
    return np.stack([curve[:count] for curve in curves])
