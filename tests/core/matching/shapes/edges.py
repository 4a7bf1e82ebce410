"""Strands and drafts of edges in small scenes, from the truth: known places, dispersions and links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.overlaps import ImagePoints
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Network, select_rows
from splinebba_cli.core.state import State, image_rays


def fragment(
    xyz: FloatArray, sigma: float = 0.05, rows: IntArray | None = None, places: FloatArray | None = None
) -> Fragment:
    """A fragment of places with round dispersions."""
    count = len(xyz)
    none = np.zeros(0, dtype=np.int64)
    return Fragment(
        xyz, np.broadcast_to(sigma**2 * np.eye(3), (count, 3, 3)).copy(), np.full(count, 3),
        np.zeros(count, dtype=bool), none if rows is None else rows, np.zeros(0) if places is None else places,
    )  # fmt: skip


def image_points(network: Network) -> ImagePoints:
    points = network.unlabelled
    rays = image_rays(network, points.image, points.photo_xy, points.sigma)
    return ImagePoints(points.image, rays.xy, points.sigma.max(axis=1))


def fragment_of(
    block: ChainBlock, curve: int, low: float, high: float, images: tuple[int, ...], seed: int = 1, sigma: float = 0.05
) -> Fragment:  # fmt: skip
    """The places low .. high of a true curve with noise, linked to the points of some images."""
    place = np.arange(int(np.ceil(low)), int(high) + 1)
    noise = np.random.default_rng(seed).normal(0.0, sigma, (len(place), 3))
    points = block.network.unlabelled
    inside = (block.curve == curve) & (block.place >= place[0]) & (block.place <= place[-1])
    rows = np.flatnonzero(inside & np.isin(points.image, images))
    return fragment(block.curves[curve][place] + noise, sigma, rows, block.place[rows] - place[0])


def state_of(network: Network) -> State:
    """The given orientations of a network without curves."""
    images = network.images
    return State(images.rotation, images.position, np.zeros((0, 3)), network.points.xyz, np.zeros(0))


def curve_through(xyz: FloatArray, id: str = "new-1", every: int = 8) -> Curve:
    """A tie spline through every so many points, with arc lengths as parameters."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xyz, axis=0), axis=1))])
    kept = np.unique(np.append(np.arange(0, len(xyz), every), len(xyz) - 1))
    return Curve(
        id, "tie", "natural_cubic", xyz[kept], np.full((len(kept), 3), np.inf), knot_parameters=along[kept]
    )


def draft_through(block: ChainBlock, curves: list[Curve], links: dict[int, int]) -> Draft:
    """A draft whose curves have the points of true curves.

    Parameters
    ----------
    links : from true curve to curve of the draft
    """
    rows = np.flatnonzero(np.isin(block.curve, list(links)))
    label = np.array([links[int(c)] for c in block.curve[rows]])
    return draft_of(
        block.network, state_of(block.network), tuple(curves), rows, label, np.full(len(rows), np.nan)
    )


def without_points(block: ChainBlock, lost: np.ndarray) -> ChainBlock:
    """A block some of whose points nobody has traced."""
    kept = np.flatnonzero(~lost)
    network = replace(block.network, unlabelled=select_rows(block.network.unlabelled, kept))
    return replace(block, network=network, curve=block.curve[kept], place=block.place[kept])
