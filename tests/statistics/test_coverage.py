"""Coverage of 95 % intervals, case by case of ``benchmarks.coverage``: 60 seeded runs each.

The pooled coverage of each of the L lines of a case lies in the interval in which a correct program finds the share of
a single element with 1 - 0.01 / L probability (binomial; pooled elements keep a narrower one), the ratios of empirical
and predicted σ of all n elements in the chi-square interval of 1 - 0.01 / n: a correct program passes a case with at
least 98 %.  ``SPLINEBBA_LONG=1`` runs what takes more than a few seconds.
"""

from __future__ import annotations

import os

import pytest

from benchmarks.coverage import CONFIDENCE, measure
from benchmarks.coverage_cases import case
from splinebba_cli.simulation.intervals import binomial_interval, ratio_interval

RUNS = 60
SHORT = ("table_5_6", "table_5_11")
LONGER = ("table_5_5", "six-image", "families", "tangents", "both")
LONG = pytest.mark.skipif(os.environ.get("SPLINEBBA_LONG") != "1", reason="SPLINEBBA_LONG=1 runs it")
NAMES = [*SHORT, *(pytest.param(name, marks=LONG) for name in LONGER)]


@pytest.mark.parametrize("name", NAMES)
def test_intervals_cover_their_share(name: str) -> None:
    lines, solved = measure(case(name), RUNS, 1)
    assert solved == {"solved": RUNS}
    low, high = binomial_interval(RUNS, CONFIDENCE, 1.0 - 0.01 / len(lines))
    assert not [line for line in lines if not low <= line.coverage.value <= high]
    lower, upper = ratio_interval(RUNS, sum(line.elements for line in lines))
    assert not [line for line in lines if line.smallest_ratio < lower or line.largest_ratio > upper]
