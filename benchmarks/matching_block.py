"""A block of curves and unlabelled points of any size, with the truth: aerial images over a flat town.

Vertical images at 1 000 m, 10 000 pixels of 0.01 mm on a side (0.1 m on the ground), in as many strips as images in a
strip, so near that a hundred of them see each of ten thousand curves about ten times.  The curves are 20 to 150 m long:
natural splines, every tenth closed, every fifth straight.  Points lie at equal distances of u on the curves, in chains,
with noise of half a pixel; orientations are off by a few centimetres and hundredths of a milliradian.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import (
    Camera,
    Curve,
    CurveObservations,
    FloatArray,
    Images,
    IntArray,
    Network,
    PointObservations,
    Points,
    UnlabelledPoints,
)

DISTANCE_MM, HALF_MM, PIXEL_MM = 100.0, 50.0, 0.01
HEIGHT_M, HALF_M = 1000.0, 500.0
DENSITY = 1e-3  # curves per square metre
SHIFT_M, TURN_RAD = 0.05, 3e-5  # of orientations
RANDOM_SHARE = 0.3


@dataclass(frozen=True)
class MatchingBlock:
    """A network without labels, and what they would be."""

    network: Network
    curve: IntArray  # (n,) of every unlabelled point, -1: random


def matching_block(images: int, curves: int, points: int, seed: int = 1) -> MatchingBlock:
    """A block of about so many images, curves, and unlabelled points."""
    generator = np.random.default_rng(seed)
    side = max(1, round(np.sqrt(images)))
    width = np.sqrt(curves / DENSITY)
    centres = np.linspace(HALF_M, max(width - HALF_M, HALF_M), side) if side > 1 else np.array([0.5 * width])
    x, y = np.meshgrid(centres, centres)
    count = side * side
    position = np.stack([x.ravel(), y.ravel(), np.full(count, HEIGHT_M)], axis=1)
    features = [_curve(generator, str(k), width, k) for k in range(curves)]
    rotation = rotation_from_vector(generator.normal(0.0, 0.02, (count, 3)))
    image, curve, xy = _measured(
        generator, features, rotation, position, round((1.0 - RANDOM_SHARE) * points)
    )
    extra = points - len(image)
    everywhere = generator.uniform(-HALF_MM, HALF_MM, (extra, 2))
    chain = np.unique(image * curves + curve, return_inverse=True)[1]
    chains = int(chain.max()) + 1
    unlabelled = UnlabelledPoints(
        image=np.concatenate([image, generator.integers(0, count, extra)]),
        photo_xy=np.concatenate([xy + generator.normal(0.0, 0.5 * PIXEL_MM, xy.shape), everywhere]),
        sigma=np.full((points, 2), 0.5 * PIXEL_MM),
        chain=np.concatenate([chain, np.full(extra, -1)]),
        direction=np.full(points, np.nan),
        chain_ids=tuple(str(k) for k in range(chains)),
    )
    moved = position + generator.normal(0.0, SHIFT_M, position.shape)
    turned = rotation @ rotation_from_vector(generator.normal(0.0, TURN_RAD, (count, 3)))
    return MatchingBlock(
        _network(features, turned, moved, unlabelled), np.concatenate([curve, np.full(extra, -1)])
    )


def _curve(generator: np.random.Generator, name: str, width: float, number: int) -> Curve:
    """A closed spline, a straight line or an open spline."""
    start = generator.uniform(0.0, width, 2)
    heading = generator.uniform(0.0, 2.0 * np.pi)
    length = generator.uniform(20.0, 150.0)
    straight, closed = number % 5 == 1, number % 10 == 0
    steps = 1 if straight else int(length / 12.0) + 3
    if closed:
        turns = np.full(steps, 2.0 * np.pi / steps) + generator.normal(0.0, 0.1, steps)
    else:
        turns = generator.normal(0.0, 0.2, steps)
    angle = heading + np.cumsum(turns)
    ways = length / steps * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    plane = start + np.concatenate([np.zeros((1, 2)), np.cumsum(ways, axis=0)])
    plane = plane[:-1] if closed else plane
    heights = 10.0 + np.cumsum(generator.normal(0.0, 0.5, len(plane)))
    values = np.column_stack([plane, heights])
    family = "straight_line" if straight else "natural_cubic"
    return Curve(name, "control", family, values, np.zeros(values.shape), closed=closed)


def _measured(
    generator: np.random.Generator, features: list[Curve], rotation: FloatArray, position: FloatArray, number: int
) -> tuple[IntArray, IntArray, FloatArray]:  # fmt: skip
    """Image, curve and place of about `number` points on curves in frames, sorted by image and curve."""
    curves = CurveSet.of([basis_of(curve) for curve in features])
    coefficients = np.vstack(
        [b.coefficients_from_values(f.values) for b, f in zip(curves.bases, features, strict=True)]
    )
    middle = np.array([feature.values.mean(axis=0) for feature in features])
    seen = [np.flatnonzero(np.abs(middle - at)[:, :2].max(axis=1) < HALF_M) for at in position]
    each = max(1, round(number / max(1, sum(len(own) for own in seen))))
    images, owners, places = [], [], []
    for k, own in enumerate(seen):
        curve = np.repeat(own, each)
        part = (np.tile(np.arange(each), len(own)) + generator.uniform(0.0, 1.0, len(curve))) / each
        u = curves.first[curve] + part * (curves.last - curves.first)[curve]
        (xyz,) = curves.evaluate(coefficients, curve, u)
        xy = project(np.full(len(u), DISTANCE_MM), rotation[k][None], position[k], xyz)
        inside = (np.abs(xy) < HALF_MM).all(axis=1)
        images.append(np.full(np.count_nonzero(inside), k))
        owners.append(curve[inside])
        places.append(xy[inside])
    image, curve, xy = np.concatenate(images), np.concatenate(owners), np.concatenate(places)
    return image[:number], curve[:number], xy[:number]


def _network(
    features: list[Curve], rotation: FloatArray, position: FloatArray, unlabelled: UnlabelledPoints
) -> Network:
    count, none, two = len(position), np.zeros(0, dtype=np.int64), np.zeros((0, 2))
    three = np.zeros((0, 3))
    return Network(
        origin=np.zeros(3),
        cameras=(
            Camera("camera", DISTANCE_MM, np.zeros(2), np.zeros(3), np.zeros(2), np.zeros(2), PIXEL_MM,
                   (2.0 * HALF_MM, 2.0 * HALF_MM)),
        ),
        images=Images(
            tuple(str(k) for k in range(count)), np.zeros(count, dtype=np.int64), rotation, position,
            ("omega-phi-kappa",) * count, np.full((count, 6), np.nan), np.full((count, 6), np.inf),
        ),
        points=Points((), (), three, three, three),
        curves=tuple(features),
        point_observations=PointObservations(none, none, two, two),
        curve_observations=CurveObservations(none, none, two, two, np.zeros(0), none),
        unlabelled=unlabelled,
    )  # fmt: skip
