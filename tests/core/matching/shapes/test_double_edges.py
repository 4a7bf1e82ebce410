"""Two edges side by side that were taken for one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.matching.shapes.double_edges import clusters_beside, without_second_edges
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.known_edges import double_edge_problems
from splinebba_cli.core.matching.shapes.new_curve_problems import second_edge_problems
from splinebba_cli.core.matching.shapes.second_edges import split
from splinebba_cli.core.network import Network
from tests.core.matching.fragments.small_scenes import CORNERS, scene, straight
from tests.core.matching.shapes.edges import curve_through, draft_through, state_of

FIRST = straight((-40.0, -20.0, 10.0), (1.0, 0.2, 0.0), 60)
APART_M = 0.3  # 5 pixels
SECOND = FIRST + np.array([0.0, APART_M, 0.0])


def test_one_edge_is_left_alone() -> None:
    block = scene([FIRST])
    draft = draft_through(block, [curve_through(FIRST)], {0: 0}).solved()
    same, found = without_second_edges(draft, block.network.unlabelled.chain)
    assert found == []
    assert len(same.row) == len(draft.row)


def mixed(of_second: tuple[int, ...]) -> tuple[ChainBlock, Draft]:
    """Points of the first edge, but of the second one in some of five images; all linked to one curve."""
    block = scene([FIRST, SECOND], np.vstack([CORNERS, [[0.0, 0.0]]]))
    image = block.network.unlabelled.image
    rows = np.flatnonzero((block.curve == 1) == np.isin(image, of_second))
    draft = draft_of(
        block.network, state_of(block.network), (curve_through(FIRST),), rows,
        np.zeros(len(rows), dtype=np.int64), np.full(len(rows), np.nan),
    )  # fmt: skip
    return block, draft.solved()


def test_the_chain_of_the_second_edge_is_found_though_the_curve_gives_way() -> None:
    block, draft = mixed((2,))
    kept, found = without_second_edges(draft, block.network.unlabelled.chain)
    assert {one.image for one in found} == {2}
    assert (block.curve[kept.row] == 0).all()
    assert (
        abs(kept.prepared.curves.bases[0].evaluate(np.array([45.0]), kept.state.coefficients)[0, 2] - 10.0)
        < 0.3
    )


def test_a_second_edge_of_two_images_becomes_a_curve() -> None:
    """Images 0 and 3 show the second one; no height explains them together with the other three."""
    block, draft = mixed((0, 3))
    apart, found = split(block.network, draft, block.network.unlabelled.chain)
    assert [curve.id for curve in apart.curves] == ["new-1", "new-2"]
    for k in range(2):
        label = block.curve[apart.row[apart.links.curve == k]]
        assert np.bincount(label, minlength=2).max() == len(label)
    assert found[0].other == "new-2"
    (problem,) = second_edge_problems(block.network, found)
    assert problem.code == "SBB597"
    assert "they make spline `new-2`" in problem.message


def test_clusters_on_two_sides_of_a_known_curve() -> None:
    generator = np.random.default_rng(1)
    location = np.tile(np.linspace(0.0, 90.0, 30), 5)
    chain, image = np.repeat(np.arange(5), 30), np.repeat(np.arange(5), 30)
    residual = generator.normal(0.0, 1.0, 150)
    assert clusters_beside(location, residual, chain) is None
    residual[chain >= 3] += 6.0
    found = clusters_beside(location, residual, chain)
    assert found is not None
    assert found.minority.tolist() == [3, 4]
    assert abs(found.apart - 6.0) < 1.0
    curve = np.zeros(150, dtype=np.int64)
    (problem,) = double_edge_problems(_named(), curve, location, residual, image, chain)
    assert problem.code == "SBB598"
    assert "2 chains of them on one side" in problem.message


def test_a_bend_is_no_second_edge() -> None:
    """Residuals that grow from chain to chain, as those of a tilted image do, have no gap between two groups."""
    chain = np.repeat(np.arange(6), 20)
    residual = chain * 1.2 + np.random.default_rng(2).normal(0.0, 0.5, 120)
    assert clusters_beside(np.tile(np.arange(20.0), 6), residual, chain) is None


def _named() -> Network:
    return replace(scene([FIRST]).network, curves=(curve_through(FIRST, "roof-1"),))
