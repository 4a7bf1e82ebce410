"""Links of points to new curves: whatever the order of chains, with points given twice, and where there is no curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import build_curves
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.extent import point_spacing
from splinebba_cli.core.matching.shapes.linking import Gate, links_to
from splinebba_cli.core.network import IntArray, Network
from tests.core.matching.fragments.small_scenes import arc, scene, straight
from tests.core.matching.shapes.edges import curve_through, draft_through, state_of

GATE = Gate(4.0, 0.35)


@pytest.fixture(scope="module")
def block() -> ChainBlock:
    return scene([arc(40.0, 2.5), straight((-40.0, -70.0, 20.0), (1.0, 0.1, 0.0), 60)])


@pytest.fixture(scope="module")
def draft(block: ChainBlock) -> Draft:
    curves = [curve_through(xyz, f"new-{k + 1}") for k, xyz in enumerate(block.curves)]
    return draft_through(block, curves, {0: 0, 1: 1}).solved()


def by_chain(network: Network) -> IntArray:
    """Rows as they are linked: chain after chain."""
    return np.argsort(network.unlabelled.chain, kind="stable")


def test_links_do_not_depend_on_the_numbers_of_chains(block: ChainBlock, draft: Draft) -> None:
    points = block.network.unlabelled
    turned = replace(
        block.network,
        unlabelled=replace(
            points, chain=points.chain.max() - points.chain, chain_ids=tuple(reversed(points.chain_ids))
        ),
    )
    found = []
    for network in (block.network, turned):
        rows, curve = by_chain(network), np.full(len(points), -1)
        curve[rows] = links_to(network, draft, rows, GATE)[1]
        found.append(curve)
    assert (found[0] >= 0).mean() > 0.95
    np.testing.assert_array_equal(found[0], found[1])


def test_points_given_twice_say_nothing_about_spacings(block: ChainBlock, draft: Draft) -> None:
    twice = np.repeat(np.arange(len(draft.row)), 2)
    double = draft_of(
        block.network, draft.state, draft.present_curves(), draft.row[twice], draft.links.curve[twice],
        draft.state.location[twice],
    )  # fmt: skip
    once = point_spacing(draft)
    assert np.all(once > 0.1)
    np.testing.assert_allclose(point_spacing(double), once, rtol=0.2)


def test_no_fragments_are_no_curves(block: ChainBlock) -> None:
    new = build_curves(block.network, state_of(block.network), [], MatchSettings())
    assert new.curves == () and new.built == () and (new.curve == -1).all()
