"""The global test with and without weak gauge conditions."""

from __future__ import annotations

from dataclasses import replace

import pytest
from scipy import stats

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.quality.global_test import global_test
from splinebba_cli.simulation.six_image_block import simulate_block


def test_bounds_are_quantiles() -> None:
    found = global_test(105.0, 100.0, 1.0, 0.05)
    assert found is not None and found.passed
    assert (found.lower, found.upper) == pytest.approx(stats.chi2(100).interval(0.95))
    assert global_test(0.0, 0.0, 1.0, 0.05) is None


def test_conditions_open_the_lower_bound_only() -> None:
    found, plain = global_test(70.0, 100.0, 1.0, 0.05, 20.0), global_test(70.0, 100.0, 1.0, 0.05)
    assert found is not None and plain is not None
    assert found.passed and not plain.passed
    assert found.lower == pytest.approx(stats.chi2(80).ppf(0.025)) and found.upper == plain.upper
    only = global_test(0.5, 3.0, 1.0, 0.05, 3.0)
    assert only is not None and only.lower == 0.0 and only.passed


def test_a_reference_that_is_right_makes_no_small_residuals() -> None:
    """Conditions with a true reference have redundancy (32 of 670) and hardly any cost: σ need not be smaller."""
    network, _ = simulate_block(
        "six-image-mixed", 1, start_position_m=0.5, start_angle_deg=0.1, start_knots_m=0.3
    )
    result = adjust(replace(network, settings=replace(network.settings, gauge_conditions="all")))
    statistics, test = result.statistics, result.statistics.global_test
    assert test is not None and statistics.condition_redundancy > 20.0 * statistics.condition_cost
    assert test.passed
    assert test.lower == pytest.approx(
        stats.chi2(statistics.redundancy - statistics.condition_redundancy).ppf(0.025)
    )
