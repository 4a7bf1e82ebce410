"""From fragments to tie splines: whole scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.matching.fragments.fragment import Fragment
from splinebba_cli.core.matching.match import with_labels
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import NewCurves, build_curves
from splinebba_cli.core.matching.shapes.names import new_ids
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.state import State, initial_coefficients, prepare
from tests.core.matching.fragments.small_scenes import arc, scene, straight
from tests.core.matching.shapes.edges import curve_through, fragment_of, state_of, without_points
from tests.reference_data import with_fixed_images

IMAGES = (0, 1, 2, 3)


def edges() -> list[FloatArray]:
    line = straight((-40.0, -70.0, 20.0), (1.0, 0.1, 0.0), 60)
    return [arc(40.0, 2.5), line, line + np.array([0.0, 0.3, 0.0])]  # the last two are 5 pixels apart


@pytest.fixture(scope="module")
def block() -> ChainBlock:
    return scene(edges())


@pytest.fixture(scope="module")
def pieces(block: ChainBlock) -> list[Fragment]:
    """Every edge in overlapping pieces, one with a gap, some twice."""
    return [
        fragment_of(block, 0, 0, 30, IMAGES, 1), fragment_of(block, 0, 22, 59, IMAGES, 2),
        fragment_of(block, 0, 10, 50, IMAGES, 3), fragment_of(block, 1, 0, 25, IMAGES, 4),
        fragment_of(block, 1, 31, 59, IMAGES, 5), fragment_of(block, 2, 0, 59, IMAGES, 6),
    ]  # fmt: skip


@pytest.fixture(scope="module")
def new(block: ChainBlock, pieces: list[Fragment]) -> NewCurves:
    return build_curves(block.network, state_of(block.network), pieces, MatchSettings())


def largest_distance(new: NewCurves, curve: int, xyz: FloatArray) -> float:
    basis = basis_of(new.curves[curve])
    coefficients = basis.coefficients_from_values(new.curves[curve].values)
    return float(nearest_on_curve(basis, coefficients, xyz)[1].max())


def test_pieces_become_the_edges_that_they_show(block: ChainBlock, new: NewCurves) -> None:
    assert len(new.curves) == 3
    label = [np.bincount(block.curve[new.curve == k]).argmax() for k in range(3)]
    assert sorted(label) == [0, 1, 2]
    for k, true in enumerate(label):
        assert largest_distance(new, k, block.curves[true][2:-2]) < 0.15  # five sigma of a height


def test_points_are_linked_and_double_edges_kept_apart(block: ChainBlock, new: NewCurves) -> None:
    linked = new.curve >= 0
    assert linked.mean() > 0.97
    for k in range(3):
        label = block.curve[new.curve == k]
        assert np.bincount(label).max() >= 0.99 * len(label)
    assert np.isfinite(new.location[linked]).all()
    assert np.isnan(new.location[~linked]).all()


def test_what_is_told_of_the_new_curves(new: NewCurves) -> None:
    assert [one.curve for one in new.built] == [0, 1, 2]
    for one in new.built:
        assert len(one.images) == 4
        assert len(one.chains) == 4
        assert 80.0 < one.length_m < 130.0
        assert one.length_in_three_images_m > 0.9 * one.length_m


def test_the_result_can_be_adjusted(block: ChainBlock, new: NewCurves) -> None:
    network = with_fixed_images(
        with_labels(replace(block.network, curves=new.curves), new.curve, new.location)
    )
    result = adjust(network)
    assert 0.9 < result.statistics.sigma0 < 1.1


def test_ids_never_collide(block: ChainBlock, pieces: list[Fragment]) -> None:
    assert new_ids(3, ["new-2", "x"]) == ("new-1", "new-3", "new-4")
    other = curve_through(straight((500.0, 500.0, 0.0), (1.0, 0.0, 0.0)), "new-1")
    network = replace(block.network, curves=(other,))
    found = build_curves(network, given_state(network), pieces[-1:], MatchSettings())
    assert [curve.id for curve in found.curves] == ["new-2"]


def given_state(network: Network) -> State:
    return replace(state_of(network), coefficients=initial_coefficients(prepare(network)))


def kerb(block: ChainBlock) -> Curve:
    """The first of the two edges side by side, known to 2 cm."""
    curve = curve_through(block.curves[1], "kerb")
    return replace(curve, role="control", sigma=np.full(curve.values.shape, 0.02))


def test_an_edge_that_the_project_has_stays_one_curve(block: ChainBlock, pieces: list[Fragment]) -> None:
    given = kerb(block)
    network = replace(block.network, curves=(given,))
    found = build_curves(network, given_state(network), pieces[3:5], MatchSettings())
    assert found.curves == ()
    assert (found.on_given >= 0).sum() > 0.9 * (block.curve == 1).sum()
    assert {problem.code for problem in found.problems} == {"SBB596"}
    assert "kerb" in found.problems[0].message


def test_of_two_given_curves_at_one_edge_none_is_chosen(block: ChainBlock, pieces: list[Fragment]) -> None:
    given = kerb(block)
    network = replace(block.network, curves=(given, replace(given, id="copy")))
    found = build_curves(network, given_state(network), pieces[3:5], MatchSettings())
    assert found.curves == ()
    assert (found.on_given == -1).all()
    assert (found.curve == -1).all()
    assert ["`kerb` and `copy`" in problem.message for problem in found.problems] == [True]


def test_the_edge_beside_a_given_one_is_new(block: ChainBlock, pieces: list[Fragment]) -> None:
    given = kerb(block)
    network = replace(block.network, curves=(given,))
    found = build_curves(network, given_state(network), pieces[5:], MatchSettings())
    assert len(found.curves) == 1
    assert (found.on_given < 0).all()


def test_no_fragments_no_curves(block: ChainBlock) -> None:
    found = build_curves(block.network, state_of(block.network), [], MatchSettings())
    assert found.curves == ()
    assert (found.curve == -1).all()


def test_fragments_that_one_image_alone_shows_make_no_curve(block: ChainBlock) -> None:
    rows = np.flatnonzero(block.network.unlabelled.image == 0)
    piece = fragment_of(block, 0, 0, 40, (0,))
    found = build_curves(block.network, state_of(block.network), [piece], MatchSettings(), rows)
    assert found.curves == ()


def test_only_given_rows_are_linked(block: ChainBlock, pieces: list[Fragment]) -> None:
    rows = np.flatnonzero(block.network.unlabelled.image != 3)
    found = build_curves(block.network, state_of(block.network), pieces[:3], MatchSettings(), rows)
    assert (found.curve[block.network.unlabelled.image == 3] == -1).all()
    assert (found.curve[rows] == 0).sum() > 0.9 * (block.curve[rows] == 0).sum()


def test_fragments_of_chains_become_splines() -> None:
    """The whole way: chains of four images, a gap of one edge that only one image bridges."""
    block = scene(edges()[:2])
    image = block.network.unlabelled.image
    block = without_points(block, (block.curve == 1) & (block.place > 24) & (block.place < 36) & (image != 2))
    images = block.network.images
    fragments = build_fragments(block.network, images.rotation, images.position)
    new = build_curves(block.network, state_of(block.network), fragments, MatchSettings())
    assert len(new.curves) == 2
    (line,) = (k for k in range(2) if np.bincount(block.curve[new.curve == k]).argmax() == 1)
    assert largest_distance(new, line, block.curves[1][2:-2]) < 0.2
    assert "bridged" in {part.kind for part in new.built[line].weak_parts}
