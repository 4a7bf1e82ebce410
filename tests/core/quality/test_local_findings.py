"""The worst observation is named, where chance does not explain it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import SystematicEffect
from splinebba_cli.core.network import Network
from splinebba_cli.core.quality.systematic_findings import systematic_findings
from splinebba_cli.core.result import AdjustmentResult, Problem
from splinebba_cli.core.settings import LocalTesting, OutlierPolicy
from splinebba_cli.simulation.six_image_block import simulate_block


@cache
def ring() -> Network:
    return simulate_block("close-range-ring", 2, start_position_m=0.03, start_knots_m=0.015)[0]


def named(result: AdjustmentResult) -> list[Problem]:
    return [problem for problem in result.problems if problem.code == "SBB557"]


def with_wrong_bar() -> Network:
    bars = ring().distances
    return replace(ring(), distances=replace(bars, length=bars.length + np.array([0.01, 0.0])))


def test_a_wrong_scale_bar_is_named_first() -> None:
    """1 cm is 200 σ of the bar; its redundancy number of 0.03 leaves w = 200 √0.03 = 35 at most."""
    result = adjust(with_wrong_bar())
    (problem,) = named(result)
    w = result.distance_residuals.standardized
    assert problem.severity == "warning"
    assert problem.message.startswith("distance from point `target-1` to point `target-2`")
    assert f"|w| = {abs(w[0]):.1f}" in problem.message


def test_tau_is_named_in_its_own_size() -> None:
    network = with_wrong_bar()
    settings = replace(network.settings, testing=LocalTesting(statistic="tau"))
    result = adjust(replace(network, settings=settings))
    (problem,) = named(result)
    tau = abs(result.distance_residuals.standardized[0]) / result.statistics.sigma0
    assert f"|τ| = {tau:.1f}" in problem.message


@pytest.mark.parametrize("kind", ["point", "spline"])
def test_image_points_are_named_with_image_and_feature(kind: str) -> None:
    network, row = ring(), 70
    table = "point_observations" if kind == "point" else "curve_observations"
    seen = getattr(network, table)
    xy = seen.photo_xy.copy()
    xy[row] += 0.15  # 30 σ
    result = adjust(replace(network, **{table: replace(seen, photo_xy=xy)}))
    (problem,) = named(result)
    image = network.images.ids[seen.image[row]]
    feature = network.points.ids[seen.point[row]] if kind == "point" else network.curves[seen.curve[row]].id
    assert problem.subject == f"image `{image}` {'of' if kind == 'point' else 'on'} {kind} `{feature}`"
    assert (f"row {row + 1} of the points on splines" in problem.message) == (kind == "spline")


def test_good_measurements_and_searches_are_left_alone() -> None:
    assert not named(adjust(ring()))
    network = with_wrong_bar()
    settings = replace(network.settings, outliers=OutlierPolicy(method="snooping"))
    assert not named(adjust(replace(network, settings=settings)))


def test_an_image_mean_says_how_much_of_a_shift_residuals_show() -> None:
    effect = SystematicEffect(
        "image mean", "image `5`", 0.057, "µm", 30.0, 10.0, significant=True, observations=99, shown=0.0008
    )
    (problem,) = systematic_findings((effect,))
    assert "all but 0.08 % of a common error" in problem.message
