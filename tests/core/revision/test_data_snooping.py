"""Data snooping: what is found, what comes back, what cannot be rejected, and where it stops."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.blunder_cases import Clean, across, clean_block, in_coordinate, largest_shift, with_policy
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray, Network, select_rows
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.revision.data_snooping import apart
from splinebba_cli.core.revision.observation_list import ObservationList
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.settings import LocalTesting, OutlierPolicy
from splinebba_cli.core.state import State

SNOOPING = OutlierPolicy("snooping")
ROWS, SIZES = np.array([40, 300, 520]), np.array([25.0, -40.0, 60.0])


@cache
def clean() -> Clean:
    return clean_block(3)


def planted() -> Network:
    """Three gross errors in different curves and images."""
    block = clean()
    return across(block.network, block.result.curve_residuals.normal, ROWS, SIZES)


@cache
def snooped() -> AdjustmentResult:
    return adjust(with_policy(planted(), SNOOPING))


def test_gross_errors_are_found_in_the_order_of_their_size_and_counted_out() -> None:
    """With r of 0.7 to 0.95 they stand far beyond the noise; what else is beyond 3.29 is a matter of chance."""
    result = snooped()
    log = result.revision.rejections
    assert [each.row for each in log[:3]] == [520, 300, 40]
    assert [each.round for each in log[:3]] == [1, 2, 3]
    assert result.statistics.redundancy == clean().result.statistics.redundancy - result.revision.rejected
    assert result.statistics.sum_redundancy_numbers == pytest.approx(result.statistics.redundancy, abs=1e-6)
    total = result.point_residuals.redundancy.sum() + result.curve_residuals.redundancy.sum()
    total += sum(each.redundancy for each in result.prior_residuals)
    assert total == pytest.approx(result.statistics.redundancy, abs=1e-6)
    assert largest_shift(clean().result, result) < 1.0


def test_predicted_residuals_are_the_errors_themselves() -> None:
    """v = adjusted - measured is minus the error, up to noise and the precision of the curve (below 1.2 σ together)."""
    result = snooped()
    found = result.curve_residuals.across[ROWS] / 0.005
    assert (np.abs(found + SIZES) < 5.0 * 1.2).all()
    assert (result.curve_residuals.redundancy[ROWS] == 0.0).all()
    predicted = {each.row: each.predicted for each in result.revision.rejections}
    np.testing.assert_allclose(
        [predicted[int(row)] for row in ROWS], result.curve_residuals.standardized[ROWS, 0]
    )
    assert (result.network.curve_observations.sigma == 0.005).all()
    assert len(result.network.curve_observations) == len(planted().curve_observations)


def test_rejections_are_a_problem_that_names_the_worst() -> None:
    problem = next(p for p in snooped().problems if p.code == "SBB540")
    worst = snooped().revision.rejections[0].name
    assert worst in problem.message
    assert f"{snooped().revision.rejected} of 784 observations were rejected" in problem.message


def test_a_good_neighbour_of_two_errors_is_rejected_first_and_comes_back() -> None:
    """Two neighbours in error by 150 σ on the same side bend the curve between them and the next good point, whose w is
    then the largest (swamping); without the errors its prediction fits.
    """
    block = clean()
    seen = block.network.curve_observations
    of_curve = np.flatnonzero(seen.curve == 1)
    same = of_curve[seen.image[of_curve] == seen.image[of_curve[0]]]
    rows = same[np.argsort(block.result.curve_residuals.location[same])][10:12]
    network = across(block.network, block.result.curve_residuals.normal, rows, np.full(2, 150.0))
    result = adjust(with_policy(network, SNOOPING))
    log = result.revision.rejections
    returned = {each.row for each in log if each.returned}
    still = {each.row for each in log if not each.returned}
    assert log[0].returned and "fits" in log[0].reason
    assert log[0].row not in rows and abs(log[0].predicted) < 3.3
    assert set(rows.tolist()) <= still
    assert largest_shift(block.result, result) < 1.0
    weights = result.revision.curve_weights
    assert weights is not None and (weights[list(returned - still)] == 1.0).all()
    assert result.revision.rejected == len(still)


def test_both_rays_of_a_point_of_two_go_and_the_point_is_named() -> None:
    block = clean()
    seen = block.network.point_observations
    rays = np.bincount(seen.point)
    tie = np.flatnonzero((np.array(block.network.points.role) == "tie") & (rays >= 2))
    point = int(tie[np.argmin(rays[tie])])
    own = np.flatnonzero(seen.point == point)
    keep = np.setdiff1d(np.arange(len(seen)), own[2:])
    network = replace(block.network, point_observations=select_rows(seen, keep))
    start = adjust(network)
    row = int(np.flatnonzero(network.point_observations.point == point)[0])
    axis = int(np.argmax(start.point_residuals.redundancy[row]))
    assert start.point_residuals.redundancy[row, axis] > 0.05
    result = adjust(with_policy(in_coordinate(network, row, axis, 60.0), SNOOPING))
    both = np.flatnonzero(network.point_observations.point == point)
    weights = result.revision.point_weights
    assert weights is not None and (weights[both] == 0.0).all()
    id_ = network.points.ids[point]
    assert any(p.code == "SBB540" and p.subject == f"point `{id_}`" for p in result.problems)
    assert np.isnan(result.points.dispersion[point]).all()
    assert result.points.rays[point] == 0
    assert result.statistics.sum_redundancy_numbers == pytest.approx(result.statistics.redundancy, abs=1e-6)


def test_the_largest_share_stops_it_with_a_problem() -> None:
    result = adjust(with_policy(planted(), replace(SNOOPING, max_share=2.0 / 784.0 + 1e-6)))
    assert result.revision.rejected == 2
    assert any(p.code == "SBB541" and "share" in p.message for p in result.problems)


def test_the_number_of_rounds_stops_it_with_a_problem() -> None:
    result = adjust(with_policy(planted(), replace(SNOOPING, max_rounds=1)))
    assert result.revision.rejected == 1 == result.revision.rounds
    assert any(p.code == "SBB541" and "rounds" in p.message for p in result.problems)


def test_where_the_last_solution_fails_all_take_part_again_and_it_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("splinebba_cli.core.revision.revise._resolved", lambda *_: None)
    result = adjust(with_policy(planted(), SNOOPING))
    assert result.revision.rejected == 0 < len(result.revision.rejections)
    assert all("not solved" in each.reason for each in result.revision.rejections)
    assert result.statistics.redundancy == clean().result.statistics.redundancy
    assert any(p.code == "SBB543" for p in result.problems)


def test_what_the_network_cannot_do_without_is_kept_and_not_tried_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solve = WeightedNetwork.solve

    def stubborn(self: WeightedNetwork, factor: FloatArray, state: State) -> WeightedSolution | None:
        lost = factor[len(planted().point_observations) + ROWS[2]] == 0.0
        return None if lost else solve(self, factor, state)

    monkeypatch.setattr(WeightedNetwork, "solve", stubborn)
    log = adjust(with_policy(planted(), SNOOPING)).revision.rejections
    tries = [each for each in log if each.row == ROWS[2]]
    assert len(tries) == 1
    assert tries[0].returned and "could not be solved without it" in tries[0].reason
    assert {int(row) for row in ROWS[:2]} <= {each.row for each in log if not each.returned}


def test_several_at_once_are_of_different_images_and_features() -> None:
    listed = ObservationList.of(clean().network)
    chosen = apart(listed, np.arange(len(listed)), 4)
    assert len(chosen) == 4
    assert len(set(listed.image[chosen].tolist())) == len(set(listed.feature[chosen].tolist())) == 4
    fast = adjust(with_policy(planted(), replace(SNOOPING, at_once=3)))
    assert set(ROWS.tolist()) <= {each.row for each in fast.revision.rejections}
    assert fast.revision.rounds < snooped().revision.rounds


def test_tau_finds_errors_where_sigma0_is_not_known() -> None:
    """All σ stated three times too large: w finds an error of 40 σ only, tau all of them."""
    network = planted()
    points, curves = network.point_observations, network.curve_observations
    network = replace(
        network,
        point_observations=replace(points, sigma=3.0 * points.sigma),
        curve_observations=replace(curves, sigma=3.0 * curves.sigma),
        settings=replace(network.settings, testing=LocalTesting(statistic="tau")),
    )
    log = adjust(with_policy(network, SNOOPING)).revision.rejections
    assert {each.row for each in log} >= set(ROWS.tolist())
    assert log[-1].reason.startswith("tau")


def test_without_errors_and_rejections_nothing_changes() -> None:
    strict = replace(clean().network.settings, testing=LocalTesting(alpha=1e-9))
    result = adjust(with_policy(replace(clean().network, settings=strict), SNOOPING))
    assert result.revision.rejections == ()
    np.testing.assert_array_equal(result.images.eop, clean().result.images.eop)
    assert not any(p.code.startswith("SBB54") for p in result.problems)
