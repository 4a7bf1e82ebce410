"""New curves that chains prove to be one, with a corner or without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.matching.match import with_labels
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.matching.shapes.build import NewCurves, build_curves
from splinebba_cli.core.matching.shapes.curve_joints import possible_joints, turned
from splinebba_cli.core.matching.shapes.draft import Draft, draft_of
from splinebba_cli.core.matching.shapes.one_curve import joined_at_corners, joined_smoothly
from splinebba_cli.core.network import Curve, FloatArray, Network
from tests.core.matching.fragments.small_scenes import arc, scene, straight
from tests.core.matching.shapes.edges import curve_through, fragment_of, state_of
from tests.reference_data import with_fixed_images

HALF = 30
TOLERANCE = MatchSettings().knot_tolerance


def right_angle() -> FloatArray:
    """Two sides of a roof, the corner at point HALF."""
    first = straight((-30.0, 0.0, 20.0), (1.0, 0.3, 0.05), HALF + 1)
    return np.vstack([first, straight(tuple(first[-1]), (-0.3, 1.0, 0.0), HALF + 1)[1:]])


def in_two(
    block: ChainBlock, at: int, margin: int, *, missing: tuple[int, ...] = (), turn: tuple[bool, bool] = (False, False)
) -> tuple[Network, Draft]:  # fmt: skip
    """The parts of the first true curve before and after a point, with the points of all images.

    Parameters
    ----------
    margin : points between each part and the place
    missing : images whose chains are broken there
    turn : whether each part is in the other sense
    """
    xyz, points = block.curves[0], block.network.unlabelled
    parts = (
        curve_through(xyz[: at - margin + 1], "new-1", 10),
        curve_through(xyz[at + margin :], "new-2", 10),
    )
    curves = tuple(turned(part) if back else part for part, back in zip(parts, turn, strict=True))
    broken = np.isin(points.image, missing) & (block.place > at)
    chain = np.where(broken, points.chain + len(points.chain_ids), points.chain)
    names = tuple(map(str, range(2 * len(points.chain_ids))))
    network = replace(block.network, unlabelled=replace(points, chain=chain, chain_ids=names))
    rows = np.flatnonzero((block.curve == 0) & ((block.place <= at - margin) | (block.place >= at + margin)))
    label = (block.place[rows] > at).astype(np.int64)
    unknown = np.full(len(rows), np.nan)
    return network, draft_of(network, state_of(network), curves, rows, label, unknown).solved()


@pytest.fixture(scope="module")
def roof() -> ChainBlock:
    return scene([right_angle()])


@pytest.fixture(scope="module")
def built(roof: ChainBlock) -> NewCurves:
    pieces = [fragment_of(roof, 0, 0, 2 * HALF, (0, 1, 2, 3))]
    return build_curves(roof.network, state_of(roof.network), pieces, MatchSettings())


def corner_of(curve: Curve) -> FloatArray:
    (at,) = curve.breaks
    return np.asarray(curve.values[at])


def test_a_roof_edge_is_one_spline_with_a_corner(roof: ChainBlock, built: NewCurves) -> None:
    (curve,) = built.curves
    assert np.linalg.norm(corner_of(curve) - roof.curves[0][HALF]) < 0.2
    assert (built.curve == 0).mean() > 0.97  # also around the corner
    around = np.abs(roof.place - HALF) < 2.0
    assert (built.curve[around] == 0).mean() > 0.9


def test_it_can_be_adjusted(roof: ChainBlock, built: NewCurves) -> None:
    network = with_fixed_images(
        with_labels(replace(roof.network, curves=built.curves), built.curve, built.location)
    )
    result = adjust(network)
    assert 0.85 < result.statistics.sigma0 < 1.15
    assert np.linalg.norm(corner_of(result.network.curves[0]) - roof.curves[0][HALF]) < 0.2


@pytest.mark.parametrize("turn", [(False, False), (True, False), (False, True), (True, True)])
def test_sides_in_any_sense_are_joined(roof: ChainBlock, turn: tuple[bool, bool]) -> None:
    network, draft = in_two(roof, HALF, 3, turn=turn)
    found = joined_at_corners(network, draft, 4.0, TOLERANCE)
    assert len(found.curves) == 1
    assert np.linalg.norm(corner_of(found.present_curves()[0]) - roof.curves[0][HALF]) < 0.3
    assert len(found.row) > len(draft.row)  # the points around


def test_one_image_alone_shows_no_corner(roof: ChainBlock) -> None:
    network, draft = in_two(roof, HALF, 3, missing=(0, 1, 2))
    assert joined_at_corners(network, draft, 4.0, TOLERANCE) is draft


def test_two_edges_behind_each_other_stay_apart() -> None:
    """A chain that jumps in two images from an edge to one below it, which other images show beside it."""
    first = straight((-30.0, 0.0, 20.0), (1.0, 0.3, 0.0), HALF + 1)
    second = straight(tuple(first[-1] - [0.0, 0.0, 8.0]), (-0.3, 1.0, 0.0), HALF + 1)[1:]
    network, draft = in_two(scene([np.vstack([first, second])]), HALF, 3, missing=(0, 1))
    assert len(possible_joints(network, draft, corners=True)) == 1
    assert joined_at_corners(network, draft, 4.0, TOLERANCE) is draft


def test_a_broken_arc_is_one_smooth_curve() -> None:
    block = scene([arc(60.0, 1.5)])
    network, draft = in_two(block, 30, 2, missing=(0,))
    found = joined_smoothly(network, draft, TOLERANCE)
    assert len(found.curves) == 1
    assert found.curves[0].breaks == ()
    basis = basis_of(found.present_curves()[0])
    distance = nearest_on_curve(basis, found.coefficients_of(0), block.curves[0][2:-2])[1]
    assert distance.max() < 0.15  # five sigma of a height


def test_a_corner_is_not_made_smooth(roof: ChainBlock) -> None:
    network, draft = in_two(roof, HALF, 3)
    assert joined_smoothly(network, draft, TOLERANCE) is draft
