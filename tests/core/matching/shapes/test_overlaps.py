"""One edge or two: fragments side by side."""

from __future__ import annotations

import numpy as np

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.matching.shapes.grouping import groups_of
from splinebba_cli.core.matching.shapes.overlaps import Overlap, overlaps_of
from splinebba_cli.core.matching.shapes.strand import Strand, strand_of
from tests.core.matching.fragments.small_scenes import scene, straight
from tests.core.matching.shapes.edges import fragment_of, image_points

PIXEL_M = 0.06
IMAGES = (0, 1, 2, 3)


def double_edge(apart_px: float) -> ChainBlock:
    first = straight((-40.0, 5.0, 10.0), (1.0, 0.2, 0.0))
    return scene([first, first + np.array([0.0, apart_px * PIXEL_M, 0.0])])


def strands(*fragments: object) -> list[Strand]:
    return [strand for each in fragments if (strand := strand_of(each)) is not None]  # type: ignore[arg-type]


def test_fragments_with_common_points_are_one_edge() -> None:
    block = double_edge(5.0)
    own = strands(fragment_of(block, 0, 0, 25, IMAGES, 1), fragment_of(block, 0, 10, 39, IMAGES, 2))
    (overlap,) = overlaps_of(own, image_points(block.network))
    assert overlap.one_edge
    assert overlap.shared_images == 4
    assert groups_of(2, [overlap]) == [[0, 1]]


def test_the_same_edge_from_different_images_is_one_by_its_dispersion() -> None:
    block = double_edge(5.0)
    own = strands(fragment_of(block, 0, 0, 39, (0, 1), 1), fragment_of(block, 0, 0, 39, (2, 3), 2))
    (overlap,) = overlaps_of(own, image_points(block.network))
    assert overlap.shared == 0
    assert overlap.one_edge
    assert not overlap.two_edges


def test_edges_five_pixels_apart_are_two_however_bad_the_dispersion() -> None:
    """sigma of 0.4 m hides a distance of 0.3 m; images that show both lines do not."""
    block = double_edge(5.0)
    own = strands(
        fragment_of(block, 0, 0, 39, IMAGES, 1, sigma=0.4), fragment_of(block, 1, 0, 39, IMAGES, 2, sigma=0.4)
    )
    (overlap,) = overlaps_of(own, image_points(block.network))
    assert overlap.statistic < 9.0
    assert overlap.two_edges
    assert not overlap.one_edge
    assert groups_of(2, [overlap]) == [[0], [1]]


def test_edges_that_no_image_shows_together_are_two_by_their_dispersion() -> None:
    block = double_edge(8.0)
    own = strands(
        fragment_of(block, 0, 0, 39, (0, 1), 1, sigma=0.03),
        fragment_of(block, 1, 0, 39, (2, 3), 2, sigma=0.03),
    )
    found = overlaps_of(own, image_points(block.network))
    assert not any(overlap.one_edge for overlap in found)


def test_crossing_edges_have_no_common_stretch() -> None:
    block = scene(
        [straight((-30.0, 0.0, 5.0), (1.0, 0.0, 0.0)), straight((0.0, -30.0, 5.0), (0.0, 1.0, 0.0))]
    )
    own = strands(fragment_of(block, 0, 0, 39, IMAGES), fragment_of(block, 1, 0, 39, IMAGES))
    assert not any(overlap.one_edge for overlap in overlaps_of(own, image_points(block.network)))


def overlap(first: int, second: int, shared: int, same: int, separate: int, statistic: float) -> Overlap:
    return Overlap(first, second, shared, same, separate, statistic, 1)


def test_groups_do_not_join_what_an_image_proves_to_be_two() -> None:
    """0 and 1 are one edge, 1 and 2 look like one, but 0 and 2 are seen side by side twice."""
    pairs = [overlap(0, 1, 50, 3, 0, 1.0), overlap(1, 2, 0, 0, 0, 2.0), overlap(0, 2, 0, 0, 2, 3.0)]
    assert groups_of(3, pairs) == [[0, 1], [2]] or groups_of(3, pairs) == [[0, 1, 2]]
    pairs[1] = overlap(1, 2, 0, 0, 1, 2.0)
    assert groups_of(3, pairs) == [[0, 1], [2]]
