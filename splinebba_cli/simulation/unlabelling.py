"""Measured curve points as a tracing tool would give them: chains in pieces, without names, wrong ones among them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray, Network, UnlabelledPoints, select_rows

_BEND = 0.3  # rad, largest change of direction along a wrong chain, per point
_LEAST = 3  # points of a chain; shorter rests stay with the piece before them


@dataclass(frozen=True)
class ChainStyle:
    """How labels are taken away.

    Attributes
    ----------
    points : int
        Largest number of points of a chain; longer ones are broken.
    wrong_share : float
        Share of all points that belong to no curve.
    hides_ties : bool
        Whether tie splines are taken out of the project: their chains stay.
    """

    points: int = 25
    wrong_share: float = 0.0
    hides_ties: bool = False


@dataclass(frozen=True)
class Unlabelled:
    """A network whose curve points have no labels, and what the labels were."""

    network: Network
    labels: tuple[tuple[str, str, str], ...]  # image, chain, id of the curve (empty: none) of every chain


def unlabelled(network: Network, style: ChainStyle, seed: int) -> Unlabelled:
    """Take the labels of all measured curve points away; excluded ones are dropped.

    Parameters
    ----------
    seed : of breaks, wrong chains and the order of the chains
    """
    generator = np.random.default_rng(np.random.SeedSequence(seed).spawn(6)[5])
    pieces = [(image, curve, rows) for image, curve, rows in _pieces(network, style, generator)]
    observed = network.curve_observations
    chains = [(image, curve, observed.photo_xy[rows]) for image, curve, rows in pieces]
    sigma = observed.sigma[pieces[0][2][0]] if pieces else np.ones(2)
    chains += _wrong_chains(network, chains, style, sigma, generator)
    order = generator.permutation(len(chains))
    chains = sorted(
        (chains[k] for k in order), key=lambda chain: chain[0]
    )  # stable: mixed inside of an image
    numbers = _numbers_in_image([image for image, _, _ in chains])
    ids = [
        (network.images.ids[image], str(number))
        for (image, _, _), number in zip(chains, numbers, strict=True)
    ]
    sizes = [len(xy) for _, _, xy in chains]
    total = sum(sizes)
    points = UnlabelledPoints(
        image=np.repeat(np.array([image for image, _, _ in chains], dtype=np.int64), sizes),
        photo_xy=np.concatenate([xy for _, _, xy in chains]) if chains else np.zeros((0, 2)),
        sigma=np.tile(sigma, (total, 1)),
        chain=np.repeat(np.arange(len(chains)), sizes),
        direction=np.full(total, np.nan),
        chain_ids=tuple(f"{image}/{number}" for image, number in ids),
    )
    names = [curve.id for curve in network.curves]
    labels = tuple(
        (*id, names[curve] if curve >= 0 else "") for id, (_, curve, _) in zip(ids, chains, strict=True)
    )
    kept = [curve for curve in network.curves if not (style.hides_ties and curve.role == "tie")]
    empty = select_rows(observed, np.zeros(0, dtype=np.int64))
    return Unlabelled(
        replace(network, curves=tuple(kept), curve_observations=empty, unlabelled=points), labels
    )


def _pieces(
    network: Network, style: ChainStyle, generator: np.random.Generator
) -> list[tuple[int, int, IntArray]]:
    """Rows of measured points in the order of tracing, broken at random places: image, curve, rows."""
    observed = network.curve_observations
    used = np.ones(len(observed), dtype=bool) if observed.excluded is None else ~observed.excluded
    rows = np.flatnonzero(used)
    key = observed.image[rows] * max(len(network.curves), 1) + observed.curve[rows]
    out = []
    for value in np.unique(key):
        own = rows[key == value]
        own = own if generator.random() < 0.5 else own[::-1]  # either sense
        while len(own):
            size = int(generator.integers(max(style.points // 2, _LEAST), style.points + 1))
            size = len(own) if len(own) - size < _LEAST else size
            out.append((int(observed.image[own[0]]), int(observed.curve[own[0]]), own[:size]))
            own = own[size:]
    return out


def _wrong_chains(
    network: Network,
    right: list[tuple[int, int, FloatArray]],
    style: ChainStyle,
    sigma: FloatArray,
    generator: np.random.Generator,
) -> list[tuple[int, int, FloatArray]]:
    """Chains of no curve: they wander through the images, with the sizes and point distances of the right ones."""
    total = sum(len(xy) for _, _, xy in right)
    wanted = round(total * style.wrong_share / (1.0 - style.wrong_share))
    out: list[tuple[int, int, FloatArray]] = []
    while wanted > 0:
        image, _, like = right[int(generator.integers(len(right)))]
        size = min(len(like), wanted)
        camera = network.cameras[int(network.images.camera[image])]
        half = 0.5 * np.array(camera.format_mm) if camera.format_mm else np.abs(like).max(axis=0)
        step = np.linalg.norm(like[1] - like[0]) if len(like) > 1 else 1.0
        turn = generator.uniform(-_BEND, _BEND) / max(size, 1)
        angle = generator.uniform(0.0, 2.0 * np.pi) + turn * np.arange(size)
        moves = step * np.column_stack([np.cos(angle), np.sin(angle)])
        path = (
            generator.uniform(-half, half)
            + np.cumsum(moves, axis=0)
            + sigma * generator.standard_normal((size, 2))
        )
        path = path[(np.abs(path) <= half).all(axis=1)]
        if len(path) >= min(_LEAST, size):
            out.append((image, -1, path))
            wanted -= len(path)
    return out


def _numbers_in_image(images: list[int]) -> list[int]:
    """1, 2, 3 … for the chains of every image, which stand together."""
    counted: dict[int, int] = {}
    out = []
    for image in images:
        counted[image] = counted.get(image, 0) + 1
        out.append(counted[image])
    return out
