"""What is said about chains that tie curves were sought in."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.matching.fragments.fragment_findings import fragment_problems
from tests.core.matching.fragments.small_scenes import arc, scene, straight

EDGES = [arc(60.0, 2.5), straight((-120.0, 70.0, 0.0), (1.0, -0.4, 0.05))]


def test_all_is_well() -> None:
    network = scene(EDGES).network
    images = network.images
    fragments = build_fragments(network, images.rotation, images.position)
    assert fragment_problems(network, images.rotation, images.position, fragments) == []


def test_chains_that_are_left_over_are_named() -> None:
    block = scene(EDGES)
    images, points = block.network.images, block.network.unlabelled
    rows = np.flatnonzero((block.curve == 0) | (points.image == 2))
    fragments = build_fragments(block.network, images.rotation, images.position, rows=rows)
    (problem,) = fragment_problems(block.network, images.rotation, images.position, fragments, rows)
    left = points.chain_ids[points.chain[(block.curve == 1) & (points.image == 2)][0]]
    assert problem.code == "SBB591"
    assert problem.message == f"1 of 5 chains belong to no tie curve: `{left}`"


def test_jumps_are_named() -> None:
    block = scene(EDGES)
    images, points = block.network.images, block.network.unlabelled
    first = np.flatnonzero(points.chain == 0)
    rows = np.setdiff1d(np.arange(len(points)), first[10:20])
    fragments = build_fragments(block.network, images.rotation, images.position, rows=rows)
    (problem,) = fragment_problems(block.network, images.rotation, images.position, fragments, rows)
    assert problem.code == "SBB592"
    assert problem.message == "1 chain jumps or turns back and was cut into 2 pieces: `0`"


def test_one_image_is_too_few() -> None:
    network = scene(EDGES).network
    images = network.images
    rows = np.flatnonzero(network.unlabelled.image == 1)
    (problem,) = fragment_problems(network, images.rotation, images.position, [], rows)
    assert problem.code == "SBB590"
    assert "only one oriented image has chains" in problem.message
