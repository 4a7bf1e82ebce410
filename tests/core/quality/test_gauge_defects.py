"""Defects that gauge conditions fill are no errors; the ends of a straight line are not even a lack of measurements."""

from __future__ import annotations

from dataclasses import replace

import pytest

from splinebba_cli.core.quality.gauge_defects import before_conditions
from splinebba_cli.core.result import Problem
from tests.core.small_networks import mixed_network


@pytest.mark.parametrize(
    ("knots", "nulls", "severity"), [(2, 2, "info"), (2, 3, "warning"), (3, 2, "warning")]
)
def test_ends_of_a_straight_line(knots: int, nulls: int, severity: str) -> None:
    """More null directions than ends, or more knots than two: something is not measured."""
    network, _ = mixed_network()
    curve = next(each for each in network.curves if each.role == "tie" and not each.closed)
    line = replace(curve, values=curve.values[:knots], sigma=curve.sigma[:knots], knot_parameters=None)
    found = Problem("SBB520", "error", f"spline `{line.id}` is not determined", f"spline `{line.id}`", "")
    (said,) = before_conditions([found], replace(network, curves=(line,)), {line.id: nulls})
    assert (said.code, said.severity) == ("SBB520", severity)
    assert ("nothing to do" in said.help) == (severity == "info")
