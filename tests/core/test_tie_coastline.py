"""A long tie spline: a stretch that bends too far keeps its own conditions, not those of the whole curve."""

from __future__ import annotations

import pytest

from benchmarks.coastline_block import Coastline, coastline_network
from splinebba_cli.core.adjustment import adjust


@pytest.mark.parametrize(("knots", "seed"), [(150, 4), (200, 2)])
def test_a_tie_coast_settles_with_few_conditions(knots: int, seed: int) -> None:
    """Damped and conditioned as a whole, all conditions of these coasts came back (SBB532)."""
    result = adjust(coastline_network(Coastline(knots, overlap=0.75, role="tie", seed=seed)))
    statistics = result.statistics
    assert statistics.conditions <= knots // 10
    assert statistics.global_test.passed
    assert "SBB532" not in {problem.code for problem in result.problems}
    assert abs(statistics.sum_redundancy_numbers - statistics.redundancy) < 1e-6 * statistics.redundancy
