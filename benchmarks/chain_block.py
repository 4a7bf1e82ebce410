"""A block of vertical images over curved edges that every image traces as chains; what the truth is.

Heights between 0 and 30 m below a flight at 1 000 m; 60 % overlap along, 30 % across; a point every ten pixels, other
places of the edges in every image.  Some chains and some points are not found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.network import (
    Camera,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
    Points,
    UnlabelledPoints,
)

HEIGHT_M = 1000.0
DISTANCE_MM = 100.0
PIXEL_MM = 0.006
FORMAT_MM = (80.0, 60.0)
STEP_PX = 10.0
LOST_CHAINS, LOST_POINTS = 0.15, 0.02


@dataclass(frozen=True)
class ChainBlock:
    """A network of unlabelled chains, and what they are."""

    network: Network
    curve: IntArray  # (n,) true curve of every unlabelled point
    place: FloatArray  # (n,) true place along it, in points
    curves: FloatArray  # (c, k, 3) true curves


def chain_block(
    columns: int,
    rows: int,
    chains_an_image: int,
    *,
    points_a_chain: int = 50,
    sigma_px: float = 0.5,
    seed: int = 1,
) -> ChainBlock:
    """A block of columns x rows images."""
    generator = np.random.default_rng(seed)
    footprint = np.array(FORMAT_MM) / DISTANCE_MM * HEIGHT_M
    grid = np.array([[i, j] for j in range(rows) for i in range(columns)]) * footprint * [0.4, 0.7]
    position = np.column_stack([grid, np.full(len(grid), HEIGHT_M)])
    position += generator.normal(0.0, 5.0, position.shape)
    rotation = rotation_object_from_photo(generator.normal(0.0, 0.02, position.shape))
    low, high = -footprint / 2, grid.max(axis=0) + footprint / 2
    count = int(chains_an_image * np.prod(high - low) / np.prod(footprint))
    return seen_block(
        _edges(generator, count, points_a_chain, low, high), rotation, position, sigma_px, generator
    )


def _edges(
    generator: np.random.Generator, count: int, points: int, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Arcs on planes that slope a little, (count, points, 3)."""
    step = STEP_PX * PIXEL_MM / DISTANCE_MM * HEIGHT_M
    number = np.arange(points)
    angle = generator.uniform(0.0, 2.0 * np.pi, (count, 1)) + generator.normal(0.0, 0.02, (count, 1)) * number
    start = generator.uniform(low, high, (count, 2))
    x = start[:, :1] + np.cumsum(step * np.cos(angle), axis=1)
    y = start[:, 1:] + np.cumsum(step * np.sin(angle), axis=1)
    z = generator.uniform(0.0, 30.0, (count, 1)) + generator.normal(0.0, 0.05, (count, 1)) * step * number
    return np.stack([x, y, z], axis=2)


def seen_block(
    curves: FloatArray,
    rotation: FloatArray,
    position: FloatArray,
    sigma_px: float,
    generator: np.random.Generator,
    lost: tuple[float, float] = (LOST_CHAINS, LOST_POINTS),
) -> ChainBlock:
    """Curves (c, k, 3), given by points along them, as images see and trace them.

    Parameters
    ----------
    lost : shares of chains and of points that are not found
    """
    count, length = curves.shape[:2]
    image, xy, chain, curve, place = [], [], [], [], []
    names = 0
    for k in range(len(position)):
        t = np.arange(length - 1) + generator.uniform(0.0, 1.0, (count, 1))
        whole, part = t.astype(np.int64), (t % 1.0)[:, :, None]
        there = np.arange(count)[:, None]
        xyz = ((1.0 - part) * curves[there, whole] + part * curves[there, whole + 1]).reshape(-1, 3)
        many = np.full(len(xyz), k)
        seen_xy = project(np.full(len(xyz), DISTANCE_MM), rotation[many], position[many], xyz)
        seen = (np.abs(seen_xy) < np.array(FORMAT_MM) / 2).all(axis=1)
        seen &= np.repeat(generator.uniform(size=count) >= lost[0], length - 1)
        seen &= generator.uniform(size=len(xyz)) >= lost[1]
        own = np.repeat(np.arange(count), length - 1)[seen]
        found, index = np.unique(own, return_inverse=True)
        image.append(many[seen])
        xy.append(seen_xy[seen] + generator.normal(0.0, sigma_px * PIXEL_MM, (int(seen.sum()), 2)))
        chain.append(index + names)
        curve.append(own)
        place.append(t.reshape(-1)[seen])
        names += len(found)
    points = UnlabelledPoints(
        image=np.concatenate(image),
        photo_xy=np.vstack(xy),
        sigma=np.full((sum(map(len, image)), 2), max(sigma_px, 0.1) * PIXEL_MM),
        chain=np.concatenate(chain),
        direction=np.full(sum(map(len, image)), np.nan),
        chain_ids=tuple(map(str, range(names))),
    )
    network = chain_network(points, rotation, position)
    return ChainBlock(network, np.concatenate(curve), np.concatenate(place), curves)


def chain_network(points: UnlabelledPoints, rotation: FloatArray, position: FloatArray) -> Network:
    """A network of unlabelled points alone."""
    count = len(position)
    none, two, three = np.zeros(0, dtype=np.int64), np.zeros((0, 2)), np.zeros((0, 3))
    return Network(
        origin=np.zeros(3),
        cameras=(
            Camera(
                "camera", DISTANCE_MM, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2), PIXEL_MM, FORMAT_MM
            ),
        ),
        images=Images(
            ids=tuple(f"image-{k}" for k in range(count)),
            camera=np.zeros(count, dtype=np.int64),
            rotation=rotation,
            position=position,
            sequence=("omega-phi-kappa",) * count,
            prior=np.full((count, 6), np.nan),
            prior_sigma=np.full((count, 6), np.inf),
        ),
        points=Points((), (), three, three, three),
        curves=(),
        point_observations=PointObservations(none, none, two, two),
        curve_observations=CurveObservations(none, none, two, two, np.zeros(0), none),
        unlabelled=points,
    )
