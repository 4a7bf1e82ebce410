"""Strasbourg, points only: what the tests say of manual (0.5 px) and automatic points (1 px) as two groups.

No other program gives these figures; they hold what this block says of its points (docs/variance-components.md).  The
estimates are held within their own sigma, decisions exactly.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.variance_components import strasbourg_groups
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.settings import WeightPolicy

LIMIT = 3.29  # of |w| for alpha = 0.001
SYSTEMATIC = {"SBB546", "SBB547", "SBB548", "SBB549", "SBB550", "SBB551"}


@cache
def adjusted(estimated: bool) -> AdjustmentResult:
    """The block with the given or with estimated sigma."""
    network = strasbourg_groups()
    weights = WeightPolicy(variance_components=estimated)
    return adjust(replace(network, settings=replace(network.settings, weights=weights)))


def sizes_of_w(result: AdjustmentResult) -> FloatArray:
    """Largest |w| of every image point, (n,)."""
    return np.asarray(np.nan_to_num(np.abs(result.point_residuals.standardized)).max(axis=1))


def test_manual_points_are_less_precise_than_given_and_automatic_ones_as_given() -> None:
    components = {each.group: each for each in adjusted(True).evidence.variance_components}
    for group, factor in (("manual, 0.5 px", 2.75), ("automatic, 1 px", 1.04)):
        found = components[group]
        assert found.estimated
        assert abs(found.factor - factor) < found.factor * found.sigma0_sigma
    assert not components["control points"].estimated
    assert components["control points"].factor == 1.0


def test_given_sigma_of_both_groups_fail_their_tests() -> None:
    components = {each.group: each for each in adjusted(False).evidence.variance_components}
    assert not components["manual, 0.5 px"].passed
    assert not components["automatic, 1 px"].passed
    assert abs(components["manual, 0.5 px"].sigma0 - 2.49) < components["manual, 0.5 px"].sigma0_sigma


def test_the_worst_points_are_manual_ones_of_one_image() -> None:
    result = adjusted(False)
    network, w = result.network, sizes_of_w(result)
    observed = network.point_observations
    worst = np.argsort(-w)[:5]
    names = [(network.images.ids[observed.image[k]], network.points.ids[observed.point[k]]) for k in worst]
    assert names == [("9111", point) for point in ("552", "563", "351", "651", "607")]
    assert observed.group is not None
    assert (observed.group[worst] == 0).all()
    assert (np.abs(result.point_residuals.standardized) > LIMIT).sum() == 16


def test_estimated_sigma_leave_nothing_beyond_a_critical_value() -> None:
    """Where one group of sigma is wrong, errors look systematic; with right ones no test of them alarms."""
    given, estimated = adjusted(False), adjusted(True)
    assert (sizes_of_w(estimated) < LIMIT).all()
    assert {each.code for each in given.problems} & SYSTEMATIC
    assert not {each.code for each in estimated.problems} & SYSTEMATIC
    assert any(effect.significant for effect in given.evidence.systematic)
    assert not any(effect.significant for effect in estimated.evidence.systematic)
    assert all(test.passed for test in estimated.evidence.groups)
