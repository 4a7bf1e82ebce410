"""Corners of edges, found in the images."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.shapes.corners import corner_points, cut_at_corners
from splinebba_cli.core.matching.shapes.overlaps import ImagePoints
from splinebba_cli.core.network import FloatArray
from tests.core.matching.shapes.edges import fragment

STEP = 0.06  # ten pixels


def points(images: list[FloatArray]) -> tuple[ImagePoints, np.ndarray]:
    """One chain an image."""
    image = np.repeat(np.arange(len(images)), [len(xy) for xy in images])
    xy = np.vstack(images) + np.random.default_rng(1).normal(0.0, 0.003, (len(image), 2))
    return ImagePoints(image, xy, np.full(len(image), 0.003)), image


def right_angle(count: int = 20) -> FloatArray:
    along = STEP * np.column_stack([np.arange(count), np.zeros(count)])
    return np.vstack([along, along[-1] + STEP * np.column_stack([np.zeros(count), np.arange(1, count + 1)])])


def bend(radius_steps: float = 12.0) -> FloatArray:
    angle = np.arange(40) / radius_steps
    return radius_steps * STEP * np.column_stack([np.cos(angle), np.sin(angle)])


def linked(own: ImagePoints, count: int) -> Fragment:
    """A fragment of which every image shows place n with its point n."""
    place = np.tile(np.arange(count, dtype=float), len(own.image) // count)
    xyz = np.column_stack([np.arange(count), np.zeros(count), np.zeros(count)]).astype(float)
    return fragment(xyz, rows=np.arange(len(own.image)), places=place)


def test_a_corner_is_found_where_it_is_and_once() -> None:
    own, chain = points([right_angle()])
    assert np.abs(np.flatnonzero(corner_points(own, chain)) - 19).max() <= 1
    assert corner_points(own, chain).sum() == 1


def test_a_bend_is_no_corner() -> None:
    own, chain = points([bend()])
    assert not corner_points(own, chain).any()


def test_points_without_a_chain_have_none() -> None:
    own, chain = points([right_angle()])
    assert not corner_points(own, np.full(len(chain), -1)).any()


def test_a_fragment_is_cut_at_a_corner_that_its_images_show() -> None:
    own, chain = points([right_angle()] * 3)
    first, second = cut_at_corners(linked(own, 40), corner_points(own, chain), own.image)
    assert abs(len(first) - 20) <= 2
    assert abs(len(second) - 21) <= 2
    assert (first.link_place <= len(first) - 1).all()
    assert len(first.link_row) + len(second.link_row) >= 117


def test_one_image_of_three_makes_no_corner() -> None:
    straight = STEP * np.column_stack([np.arange(40), np.zeros(40)])
    own, chain = points([right_angle(), straight, straight])
    assert len(cut_at_corners(linked(own, 40), corner_points(own, chain), own.image)) == 1
