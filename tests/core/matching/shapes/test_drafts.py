"""Curves with links: knots by need, ends, points linked chain by chain, weak parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.chain_block import ChainBlock
from splinebba_cli.core.matching.shapes.curve_normals import curve_normals
from splinebba_cli.core.matching.shapes.draft import Draft
from splinebba_cli.core.matching.shapes.extent import cut_back, extended, point_spacing
from splinebba_cli.core.matching.shapes.knot_need import with_needed_knots
from splinebba_cli.core.matching.shapes.knot_pruning import without_idle_knots
from splinebba_cli.core.matching.shapes.linking import Gate, cheapest_path, relinked
from splinebba_cli.core.matching.shapes.soundness import distorted, with_supported_knots
from splinebba_cli.core.matching.shapes.undetermined import cut_undetermined, real_curves, usual_sigma
from splinebba_cli.core.matching.shapes.weak_parts import Seen, determined_parts, seen_places, weak_parts
from splinebba_cli.core.network import Curve, FloatArray
from tests.core.matching.fragments.small_scenes import IN_LINE, arc, scene, straight
from tests.core.matching.shapes.edges import curve_through, draft_through, without_points

BEND = arc(40.0, 2.5)
LINE = straight((-40.0, -60.0, 10.0), (1.0, 0.2, 0.0), len(BEND))


def block(**more: object) -> ChainBlock:
    return scene([BEND, LINE], **more)  # type: ignore[arg-type]


def rms(draft: Draft) -> float:
    return float(np.sqrt(np.mean(draft.equations().residual[: len(draft.row)] ** 2)))


def chord(xyz: FloatArray, id: str = "new-1") -> Curve:
    return curve_through(xyz, id, every=len(xyz) - 1)


def all_rows(own: ChainBlock) -> np.ndarray:
    return np.arange(len(own.network.unlabelled))


def test_knots_come_where_residuals_run_and_not_on_a_straight_line() -> None:
    own = block()
    curves = [curve_through(BEND, "new-1", 16), chord(LINE, "new-2")]
    draft = with_needed_knots(draft_through(own, curves, {0: 0, 1: 1}), 3.0)
    bent, line = (len(curve.values) for curve in draft.curves)
    assert line == 2
    assert 6 <= bent <= 20
    assert rms(draft) < 1.3
    assert not distorted(draft).any()


def test_idle_knots_leave_and_needed_ones_stay() -> None:
    own = block()
    curves = [curve_through(BEND, "new-1", 4), curve_through(LINE, "new-2", 4)]
    draft = without_idle_knots(draft_through(own, curves, {0: 0, 1: 1}).solved())
    bent, line = (len(curve.values) for curve in draft.curves)
    assert line == 2
    assert bent >= 5
    assert rms(draft) < 1.3


def test_knots_without_links_between_them_leave() -> None:
    own = block()
    own = without_points(own, (own.curve == 1) & (own.place > 14) & (own.place < 40))
    draft = with_supported_knots(draft_through(own, [curve_through(LINE, every=4)], {1: 0}))
    along = np.array(draft.curves[0].knot_parameters)
    inside = (along > 15 * 1.5 + 0.1) & (along < 39 * 1.5 - 0.1)
    assert inside.sum() <= 1


def test_points_are_linked_to_the_curve_that_they_show_and_not_to_one_that_they_cross() -> None:
    cross = straight((-10.0, -80.0, 10.0), (0.1, 1.0, 0.0), len(LINE))
    own = scene([LINE, cross])
    draft = draft_through(own, [curve_through(LINE)], {0: 0})
    draft = relinked(own.network, draft, all_rows(own), Gate(5.0, 0.35))
    label = own.curve[draft.row]
    assert (label == 0).all()
    assert len(label) > 0.97 * (own.curve == 0).sum()


def test_points_of_an_edge_that_crosses_at_an_angle_are_not_linked_however_wide_the_gate() -> None:
    cross = straight((-30.0, -65.0, 10.0), (1.0, 0.8, 0.0), len(LINE))
    own = scene([LINE, cross])
    draft = draft_through(own, [curve_through(LINE)], {0: 0})
    draft = relinked(own.network, draft, all_rows(own), Gate(80.0, 0.35))
    assert (own.curve[draft.row] == 0).all()


def test_a_chain_changes_its_curve_only_where_that_pays() -> None:
    """Costs of two curves and of none along a chain: a short visit does not pay, the rest of the chain does."""
    cost = np.full((20, 3), 25.0)
    cost[:, 0] = 4.0
    cost[9:11, 1] = 1.0  # saves 6, two changes cost 24
    assert (cheapest_path(cost) == 0).all()
    cost[12:, 0], cost[12:, 1] = np.inf, 1.0
    assert cheapest_path(cost).tolist() == [0] * 12 + [1] * 8


def test_refused_points_are_not_linked_again() -> None:
    own = block()
    draft = draft_through(own, [curve_through(LINE)], {1: 0})
    row = int(draft.row[10])
    again = relinked(own.network, draft, all_rows(own), Gate(5.0, 0.35, frozenset({(row, 0)})))
    assert row not in again.row
    assert int(draft.row[11]) in again.row


def test_curves_grow_to_where_two_images_end() -> None:
    """Image 0 alone shows the last ten points."""
    own = block()
    image = own.network.unlabelled.image
    own = without_points(own, (own.curve == 1) & (own.place > len(LINE) - 11) & (image != 0))
    draft = draft_through(own, [curve_through(LINE[20:40])], {1: 0})
    draft = relinked(own.network, draft, all_rows(own), Gate(5.0, 0.35))
    for _ in range(8):
        draft = cut_back(relinked(own.network, extended(draft), all_rows(own), Gate(5.0, 0.35))).solved()
    ends = draft.curves[0].values[[0, -1]]
    assert np.linalg.norm(ends[0] - LINE[0]) < 3.0
    assert np.linalg.norm(ends[1] - LINE[len(LINE) - 11]) < 3.0


def test_dispersion_is_that_of_the_errors() -> None:
    """Over 60 noise samples the error across has the predicted size: chi-square with 120 degrees of freedom, 99.9 %."""
    squares = 0.0
    for seed in range(60):
        own = scene([LINE], seed=seed)
        draft = draft_through(own, [chord(LINE)], {0: 0}).solved()
        (normals,) = curve_normals(draft)
        u = np.array([0.5 * normals.basis.break_points.sum()])
        off = normals.basis.evaluate(u, normals.coefficients)[0] - LINE[0]
        tangent = (LINE[-1] - LINE[0]) / np.linalg.norm(LINE[-1] - LINE[0])
        frame = np.linalg.svd(tangent[None])[2][1:].T
        lateral = frame.T @ normals.dispersion(u)[0] @ frame
        squares += float((frame.T @ off) @ np.linalg.solve(lateral, frame.T @ off))
    assert 74.0 < squares < 178.0


def test_an_edge_along_the_line_of_flight_is_weak_and_a_gap_is_bridged() -> None:
    """Images in one line: an edge below them and along them has no depth; a gap in all images but one is bridged."""
    along = straight((-45.0, 3.0, 10.0), (1.0, 0.0, 0.0), 60)
    across = straight((0.0, -45.0, 10.0), (0.0, 1.0, 0.0), 60)
    own = scene([along, across], ground=IN_LINE)
    image = own.network.unlabelled.image
    own = without_points(own, (own.curve == 1) & (own.place > 25) & (own.place < 40) & (image > 0))
    draft = draft_through(own, [chord(along), chord(across, "new-2")], {0: 0, 1: 1}).solved()
    spacing = point_spacing(draft)
    weak, gap = (seen_places(draft, each, spacing[k]) for k, each in enumerate(curve_normals(draft)))
    usual = float(np.median(gap.sigma))
    assert {part.kind for part in weak_parts(weak, usual)} == {"epipolar"}
    (bridge,) = (part for part in weak_parts(gap, usual) if part.kind == "bridged")
    assert bridge.last - bridge.first == pytest.approx(14 * 1.5, abs=9.0)
    assert usual_sigma(draft) > usual


def test_two_images_are_told_from_three() -> None:
    own = block()
    own = without_points(own, own.network.unlabelled.image > 1)
    draft = draft_through(own, [chord(LINE)], {1: 0}).solved()
    (normals,) = curve_normals(draft)
    seen = seen_places(draft, normals, point_spacing(draft)[0])
    assert "two_images" in {part.kind for part in weak_parts(seen, float(seen.sigma.max()))}


def test_what_nothing_determines_is_cut_out() -> None:
    sigma = np.full(30, 0.1)
    sigma[12:18] = 5.0
    seen = Seen(np.arange(30.0), np.full(30, 3), sigma, np.ones(30))
    assert determined_parts(seen, 0.1) == [(0.0, 11.0), (18.0, 29.0)]
    assert determined_parts(replace(seen, sigma=np.full(30, 0.2)), 0.1) == []


def test_a_cut_curve_becomes_two_with_their_points() -> None:
    """With a usual sigma that is far too small only the middle of a straight edge counts as determined."""
    own = block()
    draft = draft_through(own, [curve_through(LINE)], {1: 0}).solved()
    (normals,) = curve_normals(draft)
    seen = seen_places(draft, normals, point_spacing(draft)[0])
    cut, cuts = cut_undetermined(own.network, draft, float(np.median(seen.sigma)) / 30.0)
    assert cuts[0].curve == "new-1"
    assert 1 <= len(cut.curves) == len(cuts[0].parts)
    assert len({curve.id for curve in cut.curves}) == len(cut.curves)
    assert len(cut.row) < len(draft.row)


def test_a_curve_of_one_image_is_none() -> None:
    own = block()
    image = own.network.unlabelled.image
    own = without_points(own, (own.curve == 1) & (image > 0))
    draft = draft_through(own, [curve_through(BEND), curve_through(LINE, "new-2")], {0: 0, 1: 1})
    assert [curve.id for curve in real_curves(own.network, draft).curves] == ["new-1"]
