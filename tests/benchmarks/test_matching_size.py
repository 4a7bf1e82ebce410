"""The benchmark of a million points, in small."""

from __future__ import annotations

import numpy as np

from benchmarks.matching_block import PIXEL_MM, RANDOM_SHARE, matching_block
from benchmarks.matching_size import measure, scene_of
from splinebba_cli.core.matching.candidates.search import find_candidates


def test_the_nearest_curve_is_nearly_always_the_right_one() -> None:
    block = matching_block(9, 300, 12_000)
    assert len(block.network.images.ids) == 9
    assert np.mean(block.curve < 0) == np.clip(
        np.mean(block.curve < 0), RANDOM_SHARE - 0.1, RANDOM_SHARE + 0.1
    )
    figures = measure(block, 5.0, 1, whole=False)
    # noise of half a pixel, orientations off by some 0.6: 5 pixels are 6 sigma; a curve crosses every 3 000th pixel
    assert figures["nearest"]["unmatched"] < 1e-3
    assert figures["nearest"]["right"] > 0.98
    assert figures["nearest"]["random_matched"] < 0.15


def test_chains_are_sorted_along_their_curves() -> None:
    block = matching_block(4, 100, 3000)
    points, scene = block.network.unlabelled, scene_of(block.network)
    found = find_candidates(scene, np.full(3000, 5.0 * PIXEL_MM))
    own = block.curve[found.point] == found.curve
    _, first = np.unique(found.point[own], return_index=True)
    point, location = found.point[own][first], found.location[own][first]
    same = (np.diff(points.chain[point]) == 0) & ~scene.curves.closed[found.curve[own][first][1:]]
    assert same.sum() > 1000
    assert np.mean(np.diff(location)[same] > 0.0) > 0.99
