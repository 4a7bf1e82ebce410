"""Variance components by iteration: where they end, and what is left alone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.variance_components import block, two_groups
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import VarianceComponent
from splinebba_cli.core.quality.observation_groups import observation_groups
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.revision.group_weights import with_factors, with_given_sigma
from splinebba_cli.core.revision.variance_components import SETTLED
from splinebba_cli.core.settings import WeightPolicy
from tests.core.small_networks import mixed_network


@cache
def adjusted(fine: float = 0.5, coarse: float = 3.0) -> AdjustmentResult:
    return adjust(two_groups(1, (fine, coarse)))


def components(result: AdjustmentResult) -> dict[str, VarianceComponent]:
    return {each.group: each for each in result.evidence.variance_components}


def test_every_estimated_group_has_a_variance_of_one_at_the_end() -> None:
    found = components(adjusted())
    assert [name for name, each in found.items() if each.estimated] == ["points", "fine", "coarse"]
    for each in found.values():
        if each.estimated:
            assert abs(each.sigma0 - 1.0) <= SETTLED * each.sigma0_sigma
            assert each.passed
        else:
            assert each.factor == 1.0
    assert adjusted().statistics.sigma0 == pytest.approx(
        1.0, abs=0.02
    )  # the groups left alone have r = 8 of 640


def test_the_end_does_not_depend_on_the_given_sigma() -> None:
    """The same measurements with other given σ: σ given times factor is the same, to the bound of the iterations."""
    other = components(adjusted(2.0, 0.7))
    for name, true in (("fine", 0.5 / 2.0), ("coarse", 3.0 / 0.7), ("points", 1.0)):
        each = components(adjusted())[name]
        assert each.factor / other[name].factor == pytest.approx(true, rel=4.0 * SETTLED * each.sigma0_sigma)


def test_the_network_of_the_result_has_the_sigma_that_were_used() -> None:
    result, given = adjusted(), two_groups(1)
    factor = components(result)["coarse"].factor
    coarse = given.curve_observations.group == 1
    used, was = result.network.curve_observations.sigma, given.curve_observations.sigma
    np.testing.assert_allclose(used[coarse], factor * was[coarse], rtol=1e-12)
    back = with_given_sigma(result.network, result.evidence.variance_components)
    np.testing.assert_allclose(back.curve_observations.sigma, was, rtol=1e-12)


def test_weak_groups_keep_their_sigma_and_are_named() -> None:
    (problem,) = [each for each in adjusted().problems if each.code == "SBB552"]
    assert problem.severity == "info"
    assert "`control points`" in problem.message and "`control splines`" in problem.message


def test_without_the_setting_a_wrong_sigma_is_named_and_nothing_changes() -> None:
    network = two_groups(1)
    network = replace(network, settings=replace(network.settings, weights=WeightPolicy()))
    result = adjust(network)
    named = {each.subject for each in result.problems if each.code == "SBB545"}
    assert named == {"group `fine`", "group `coarse`"}
    for name, true in (("fine", 0.5), ("coarse", 3.0)):
        each = components(result)[name]
        assert each.factor == 1.0 and not each.passed
        assert each.sigma0 == pytest.approx(true, abs=4.0 * each.sigma0_sigma)


def test_too_few_rounds_are_a_warning() -> None:
    network = two_groups(1)
    policy = WeightPolicy(variance_components=True, max_rounds=1)
    result = adjust(replace(network, settings=replace(network.settings, weights=policy)))
    assert [each.severity for each in result.problems if each.code == "SBB552"] == ["info", "warning"]


def test_factors_touch_their_own_group_only() -> None:
    """Every group of a network that has all kinds; fixed and free values stay fixed and free."""
    network = mixed_network()[0]
    groups = observation_groups(network)
    assert {group.kind for group in groups} >= {
        "point",
        "spline",
        "control point",
        "control spline",
        "eop prior",
    }
    for k, group in enumerate(groups):
        scaled = with_factors(network, [2.0 if i == k else 1.0 for i in range(len(groups))])
        tables = [
            (network.point_observations.sigma, scaled.point_observations.sigma),
            (network.curve_observations.sigma, scaled.curve_observations.sigma),
            (network.distances.sigma, scaled.distances.sigma),
            (network.points.sigma, scaled.points.sigma),
            (network.images.prior_sigma, scaled.images.prior_sigma),
            *((a.sigma, b.sigma) for a, b in zip(network.curves, scaled.curves, strict=True)),
        ]
        changed = sum(int((a != b).sum()) for a, b in tables)
        columns = {"point": 2, "spline": 2}.get(group.kind, 1)
        assert changed == columns * len(group.rows), group.name


def test_a_clean_block_stays_nearly_as_it_is() -> None:
    """Factors within four standard deviations of 1 (of 3 estimates: 1 - 2e-4)."""
    network = block(2)
    settings = replace(network.settings, weights=WeightPolicy(variance_components=True))
    for each in components(adjust(replace(network, settings=settings))).values():
        assert abs(each.factor - 1.0) <= 4.0 * each.sigma0_sigma


def test_a_group_that_takes_no_part_keeps_its_given_sigma() -> None:
    """Two groups, one of which was left out as a whole: it has no component, the other gets its factor back."""
    network = two_groups(1)
    used = observation_groups(network)
    gone = next(group for group in used if group.kind == "spline")
    components = tuple(
        replace(adjusted().evidence.variance_components[0], kind=group.kind, group=group.name, factor=2.0)
        for group in used
        if group is not gone
    )
    given = with_given_sigma(network, components)
    seen = network.curve_observations.sigma
    expected = 0.5 * seen
    expected[gone.rows] = seen[gone.rows]
    np.testing.assert_array_equal(given.curve_observations.sigma, expected)
    np.testing.assert_array_equal(given.point_observations.sigma, 0.5 * network.point_observations.sigma)


def test_entries_with_the_same_name_are_one_group() -> None:
    network = two_groups(1)
    seen = replace(network.curve_observations, group_names=("both", "both"))
    groups = [g for g in observation_groups(replace(network, curve_observations=seen)) if g.kind == "spline"]
    assert [(group.name, len(group.rows)) for group in groups] == [("both", len(seen))]
