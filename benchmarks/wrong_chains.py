"""Chains that are no edge of the object: random walks over the images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import IntArray, Network, UnlabelledPoints

TURNS_RAD = (0.0, 0.02, 0.1)  # standard deviation of the change of direction from point to point


def with_wrong_chains(network: Network, share: float, seed: int = 1) -> tuple[Network, IntArray]:
    """A network with so many wrong chains that they are a share of all, and the rows of their points.

    They are as long as the right ones, as dense and as noisy, and lie where the image has right ones.
    """
    points = network.unlabelled
    generator = np.random.default_rng(seed)
    image, xy, chain = [], [], []
    right = len(points.chain_ids)
    wrong = round(share / (1.0 - share) * right)
    for number in range(wrong):
        like = np.flatnonzero(points.chain == generator.integers(right))
        k, count = points.image[like[0]], max(6, len(like))
        own = points.photo_xy[points.image == k]
        step = np.median(np.linalg.norm(np.diff(points.photo_xy[like], axis=0), axis=1))
        turn = generator.normal(0.0, generator.choice(TURNS_RAD), count)
        angle = generator.uniform(0.0, 2.0 * np.pi) + np.cumsum(turn)
        walk = np.cumsum(step * np.column_stack([np.cos(angle), np.sin(angle)]), axis=0)
        start = generator.uniform(own.min(axis=0), own.max(axis=0))
        image.append(np.full(count, k))
        xy.append(start + walk + generator.normal(0.0, points.sigma[like[0], 0], (count, 2)))
        chain.append(np.full(count, right + number))
    total = sum(map(len, image))
    if not total:
        return network, np.zeros(0, dtype=np.int64)
    sigma = np.repeat(points.sigma[:1], total, axis=0)
    mixed = UnlabelledPoints(
        image=np.concatenate([points.image, *image]),
        photo_xy=np.vstack([points.photo_xy, *xy]),
        sigma=np.vstack([points.sigma, sigma]),
        chain=np.concatenate([points.chain, *chain]),
        direction=np.concatenate([points.direction, np.full(total, np.nan)]),
        chain_ids=(*points.chain_ids, *(f"wrong-{number}" for number in range(wrong))),
    )
    return replace(network, unlabelled=mixed), len(points) + np.arange(total)
