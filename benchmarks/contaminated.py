"""Unlabelled points made worse on purpose: points and chains that belong to no curve, orientations that are off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.network import FloatArray, IntArray, Network, UnlabelledPoints


def with_moved_orientations(
    network: Network, generator: np.random.Generator, position_m: float, angle_rad: float
) -> Network:
    """Approximate orientations off by normal errors of a standard deviation per coordinate and per axis."""
    images = network.images
    count = len(images.ids)
    turn = rotation_from_vector(generator.normal(0.0, angle_rad, (count, 3)))
    shift = generator.normal(0.0, position_m, (count, 3))
    return replace(
        network, images=replace(images, rotation=images.rotation @ turn, position=images.position + shift)
    )


def with_random_points(
    network: Network, label: IntArray, share: float, generator: np.random.Generator
) -> tuple[Network, IntArray]:
    """Single points anywhere among those of an image, so many that they are a share of all; labels, -1 for them.

    They have directions, any, where all points of the network have one.
    """
    points = network.unlabelled
    parts_xy, parts_image = [], []
    for image in np.unique(points.image):
        own = points.photo_xy[points.image == image]
        count = round(share / (1.0 - share) * len(own))
        parts_xy.append(generator.uniform(own.min(axis=0), own.max(axis=0), (count, 2)))
        parts_image.append(np.full(count, image))
    found, label = _appended(network, label, np.vstack(parts_xy), np.concatenate(parts_image), None)
    directed = len(points) > 0 and bool(np.isfinite(points.direction).all())
    if directed:
        direction = found.unlabelled.direction.copy()
        direction[len(points) :] = generator.uniform(-np.pi / 2.0, np.pi / 2.0, len(direction) - len(points))
        found = replace(found, unlabelled=replace(found.unlabelled, direction=direction))
    return found, label


def with_wrong_chains(
    network: Network, label: IntArray, share: float, generator: np.random.Generator, reach_mm: float
) -> tuple[Network, IntArray]:
    """Copies of chains turned by up to 30 degrees and moved by up to `reach_mm`: a share of all chains is wrong."""
    points = network.unlabelled
    parts_xy, parts_image, parts_chain = [], [], []
    number = len(points.chain_ids)
    for image in np.unique(points.image):
        chains = np.unique(points.chain[(points.image == image) & (points.chain >= 0)])
        count = round(share / (1.0 - share) * len(chains))
        for chain in generator.choice(chains, count):
            xy = points.photo_xy[points.chain == chain]
            middle, angle = xy.mean(axis=0), generator.uniform(-np.pi / 6.0, np.pi / 6.0)
            turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
            parts_xy.append((xy - middle) @ turn.T + middle + generator.uniform(-reach_mm, reach_mm, 2))
            parts_image.append(np.full(len(xy), image))
            parts_chain.append(np.full(len(xy), number))
            number += 1
    return _appended(
        network, label, np.vstack(parts_xy), np.concatenate(parts_image), np.concatenate(parts_chain)
    )


def _appended(
    network: Network, label: IntArray, xy: FloatArray, image: IntArray, chain: IntArray | None
) -> tuple[Network, IntArray]:
    """More points behind those of a network."""
    points, count = network.unlabelled, len(xy)
    own = np.full(count, -1) if chain is None else chain
    ids = tuple(f"wrong-{k}" for k in range(int(own.max(initial=-1)) + 1 - len(points.chain_ids)))
    more = UnlabelledPoints(
        image=np.concatenate([points.image, image]),
        photo_xy=np.vstack([points.photo_xy, xy]),
        sigma=np.vstack([points.sigma, np.broadcast_to(np.median(points.sigma, axis=0), (count, 2))]),
        chain=np.concatenate([points.chain, own]),
        direction=np.concatenate([points.direction, np.full(count, np.nan)]),
        chain_ids=points.chain_ids + ids,
    )
    return replace(network, unlabelled=more), np.concatenate([label, np.full(count, -1)])
