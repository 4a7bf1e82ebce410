"""Campaigns: reproducible by seed, independent of processes; failures counted; where wrong starts lead."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.errors import SimulationError
from splinebba_cli.simulation.campaign import Campaign, attempt
from splinebba_cli.simulation.campaign_statistics import failures_by_code, study_statistics
from splinebba_cli.simulation.executors import run_all
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.run_errors import largest, reference_of_result, reference_of_truth, run_errors
from splinebba_cli.simulation.run_record import Failure, RunRecord, StudyPoint, record_from
from splinebba_cli.simulation.six_image_block import kind_design, simulate_block
from splinebba_cli.simulation.targets import BLOCK_NOISE

DESIGN = kind_design("six-image-mixed", 0.005)
CAMPAIGN = Campaign(DESIGN, replace(BLOCK_NOISE, missing_pair_share=0.1), 7)


def lines(campaign: Campaign, runs: list[int], jobs: int) -> dict[int, str]:
    return {record.run: record.line() for record in run_all(campaign, runs, jobs)}


def test_runs_depend_on_seed_and_number_alone() -> None:
    one = lines(CAMPAIGN, [0, 1, 2, 3], 1)
    assert lines(CAMPAIGN, [3, 1, 2, 0], 2) == one
    later = lines(replace(CAMPAIGN, seed=9), [1], 1)[1]  # run i has the seed plus i
    assert {**json.loads(later), "run": 3} == json.loads(one[3])
    assert lines(replace(CAMPAIGN, seed=8), [0], 1)[0] != one[0]


def test_a_line_gives_the_record_back() -> None:
    (record,) = run_all(CAMPAIGN, [0], 1)
    again = record_from(json.loads(record.line()))
    assert again.line() == record.line()
    assert record.errors is not None and again.errors is not None
    np.testing.assert_allclose(again.errors.points, record.errors.points, rtol=1e-6)
    assert len(again.errors.points) == len(DESIGN.network.points.ids)  # in the numbering of the design
    assert np.isnan(again.errors.points).any()  # what the run left out
    assert [c.across.shape for c in again.errors.curves] == [(16, 2)] * len(DESIGN.network.curves)


def test_a_run_without_a_solution_is_a_record_with_its_reason() -> None:
    campaign = Campaign(kind_design("six-image-singular", 0.005), BLOCK_NOISE, 1)
    (record,) = run_all(campaign, [0], 1)
    assert record.errors is None and record.failure is not None
    assert record.failure.code == "SBB522"
    assert record_from(json.loads(record.line())).failure == record.failure


def test_an_unexpected_error_is_counted_and_does_not_end_the_campaign(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(_: object) -> None:
        raise ValueError("shapes differ")

    monkeypatch.setattr("splinebba_cli.simulation.campaign.adjust", broken)
    result, failure = attempt(DESIGN.network)
    assert result is None and failure == Failure("SBB970", "ValueError: shapes differ")


def dies(number: int) -> int:
    import os

    os._exit(number + 3)


def test_a_worker_that_dies_is_reported() -> None:
    with pytest.raises(SimulationError) as reported:
        list(run_all(dies, [0, 1, 2], 2))
    assert reported.value.code == "SBB704"


def test_errors_across_do_not_depend_on_where_knots_slide() -> None:
    """A curve moved along itself has no error; moved to the left by 1 m, it has one of 1 m."""
    network, truth = simulate_block("six-image", 1)
    result = adjust(network)
    found = reference_of_result(result)
    errors = run_errors(result, found)
    assert largest(errors) < 1e-6
    sample = result.curves[3]
    basis, coefficients = found.shapes[3]
    slid = basis.evaluate(sample.sample_u + 0.3, coefficients) + network.origin
    moved = replace(result, curves=(*result.curves[:3], replace(sample, sample_xyz=slid), *result.curves[4:]))
    inner = run_errors(moved, found).curves[3].across[:-1]  # the last one is beyond the end
    assert np.abs(inner).max() < 1e-6
    tangent = basis.evaluate(sample.sample_u, coefficients, 1)
    left = np.cross([0.0, 0.0, 1.0], tangent)
    left /= np.linalg.norm(left, axis=1)[:, None]
    shifted = replace(sample, sample_xyz=sample.sample_xyz + 1e-3 * left)
    aside = replace(result, curves=(*result.curves[:3], shifted, *result.curves[4:]))
    np.testing.assert_allclose(run_errors(aside, found).curves[3].across[:, 0], 1e-3, rtol=1e-3)
    np.testing.assert_allclose(run_errors(aside, found).curves[3].across[:, 1], 0.0, atol=1e-5)
    assert 0.1 < largest(run_errors(result, reference_of_truth(network, truth))) < 6.0
    ahead = sample.sample_xyz.copy()  # the last place 5 m beyond the end, its ellipse a little askew
    end = tangent[-1] / np.linalg.norm(tangent[-1])
    ahead[-1] += 5.0 * end
    askew = sample.sample_across_direction + 0.02 * end
    beyond = replace(sample, sample_xyz=ahead, sample_across_direction=askew)
    longer = replace(result, curves=(*result.curves[:3], beyond, *result.curves[4:]))
    assert np.abs(run_errors(longer, found).curves[3].normalized).max() < 1e-6


def test_starts_at_the_truth_always_come_back() -> None:
    campaign = Campaign(DESIGN, BLOCK_NOISE, 3, study=(0.0, 1.0))
    records = list(run_all(campaign, [0, 1, 2], 1))
    zero, one = study_statistics(records)
    assert (zero.factor, zero.runs, zero.same.value, zero.failed, zero.other_minimum) == (0.0, 3, 1.0, 0, 0)
    assert one.same.value == 1.0  # what every simulated block starts with
    assert all(record.errors is not None for record in records)


def test_starts_that_are_far_off_do_not_come_back() -> None:
    """100 m, 40 degrees and 60 m: whatever happens, it is counted as other minimum or failed."""
    far = Noise(0.005, 100.0, np.radians(40.0), 60.0)
    (record,) = run_all(Campaign(kind_design("six-image", 0.005), far, 1, study=(1.0,)), [0], 1)
    (point,) = record.study
    assert point.outcome in ("failed", "other minimum")
    assert (point.failure is not None) == (point.outcome == "failed")


def test_statistics_of_a_study() -> None:
    def record(run: int, *points: StudyPoint) -> RunRecord:
        return RunRecord(run, None, None, 1.0, 10, True, 5, points)

    reason = Failure("SBB502", "no")
    found = study_statistics(
        [
            record(1, StudyPoint(2.0, "failed", float("nan"), 0, reason), StudyPoint(1.0, "same", 1e-9, 8)),
            record(0, StudyPoint(1.0, "same", 1e-9, 10), StudyPoint(2.0, "other minimum", 40.0, 30)),
        ]
    )
    assert [each.factor for each in found] == [1.0, 2.0]
    assert (found[0].same.value, found[0].iterations) == (1.0, 9.0)
    assert (found[1].same.value, found[1].other_minimum, found[1].failed) == (0.0, 1, 1)
    assert found[1].failures == ((reason, 1),)
    assert found[0].same.lower == pytest.approx(0.005**0.5)


def test_failures_are_grouped_by_their_code() -> None:
    found = failures_by_code([Failure("SBB502", "a"), Failure("SBB522", "b"), Failure("SBB502", "c")])
    assert found == ((Failure("SBB502", "a"), 2), (Failure("SBB522", "b"), 1))
