"""Outliers and variance components together: neither spoils the other, and they end in one place."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.variance_components import two_groups
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Distances, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.settings import OutlierPolicy
from splinebba_cli.simulation.six_image_block import simulate_block

BLUNDERS = np.array([33, 250, 471])  # measured curve points
SIZE_MM = 0.6  # 40 sigma of the coarse group, 240 of the fine one


def with_blunders() -> Network:
    """Two groups of curve points, given with half and three times their sigma's share, and three gross errors."""
    network = two_groups(1)
    xy = network.curve_observations.photo_xy.copy()
    xy[BLUNDERS] += SIZE_MM / np.sqrt(2.0)
    observed = replace(network.curve_observations, photo_xy=xy)
    settings = replace(network.settings, outliers=OutlierPolicy("snooping"))
    return replace(network, curve_observations=observed, settings=settings)


@cache
def both() -> AdjustmentResult:
    return adjust(with_blunders())


def factors(result: AdjustmentResult) -> dict[str, tuple[float, float]]:
    return {each.group: (each.factor, each.sigma0_sigma) for each in result.evidence.variance_components}


def out(result: AdjustmentResult) -> set[int]:
    return {r.row for r in result.revision.rejections if r.kind == "spline" and not r.returned}


def test_gross_errors_are_out_and_the_variances_are_those_without_them() -> None:
    """Two good observations of 3.3 sigma are out of the 264 of `fine` as well: 4 % of its sigma, 0.9 of its own."""
    clean = adjust(two_groups(1))
    assert set(BLUNDERS.tolist()) <= out(both())
    for name in ("points", "fine", "coarse"):
        (factor, sigma), (other, _) = factors(both())[name], factors(clean)[name]
        assert factor == pytest.approx(other, abs=sigma * other)


def test_good_observations_of_the_coarse_group_come_back() -> None:
    """With the given sigma, a third of the true one, many of them look like gross errors; few stay out."""
    log = [each for each in both().revision.rejections if each.kind == "spline"]
    coarse = np.flatnonzero(both().network.curve_observations.group == 1)
    assert sum(each.returned and each.row in set(coarse.tolist()) for each in log) > 3
    tests = both().evidence.tests
    assert tests is not None and tests.beyond == 0
    assert len(out(both())) <= len(BLUNDERS) + 5  # 1e-3 of 900 tests are expected beyond the critical value


def test_predictions_belong_to_the_estimated_sigma() -> None:
    found = both()
    sigma = found.network.curve_observations.sigma[BLUNDERS, 0]
    across, w = found.curve_residuals.across[BLUNDERS], found.curve_residuals.standardized[BLUNDERS, 0]
    ratio = across / (sigma * w)  # sqrt(1 + a Q a') of a prediction
    assert (ratio >= 1.0).all() and (ratio < 1.5).all()
    factor = factors(found)["coarse"][0]
    given = with_blunders().curve_observations
    coarse = given.group == 1
    np.testing.assert_allclose(found.network.curve_observations.sigma[coarse], factor * given.sigma[coarse])


def test_statistics_are_consistent() -> None:
    statistics = both().statistics
    assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, abs=1e-6)
    assert statistics.sigma0 == pytest.approx(1.0, abs=0.02)


def test_wrong_distances_are_found_and_the_free_network_stays_free() -> None:
    """A scale bar 5 mm too long beside two good ones, in a network with an inner datum."""
    network, truth = simulate_block("close-range-ring", 4, start_position_m=1.0, start_angle_deg=0.3)
    points = replace(
        network.points,
        role=("tie",) * len(network.points.ids),
        sigma=np.full_like(network.points.sigma, np.inf),
        xyz=np.full_like(network.points.xyz, np.nan),
    )
    station = np.array([[4, 5], [6, 7], [8, 9], [10, 11]])
    ends = truth.points[station]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    length[2] += 0.005
    bars = Distances(station, np.zeros((4, 2), dtype=bool), length, np.full(4, 5e-5))
    settings = replace(network.settings, datum="inner", outliers=OutlierPolicy("snooping", max_share=0.01))
    result = adjust(replace(network, points=points, distances=bars, settings=settings))
    wrong = [each for each in result.revision.rejections if not each.returned]
    assert (wrong[0].kind, wrong[0].row) == ("distance", 2)
    assert wrong[0].residual == pytest.approx(-0.005, abs=5e-4)
    assert result.revision.distance_weights is not None
    assert result.revision.distance_weights.tolist() == [1.0, 1.0, 0.0, 1.0]
    assert result.statistics.rank_defect >= 6
    assert np.abs(result.distance_residuals.residual[[0, 1, 3]]).max() < 3e-4
