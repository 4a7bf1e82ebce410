"""Variance components and tests for common errors, in seeded runs; the long versions are in benchmarks/.

A correct program passes each test with at least 99 %: intervals of the mean (normal), the mean square (chi-square) and
the number of alarms (binomial), each at 0.005 a side or less.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.stats import binom

from benchmarks.variance_components import (
    FAMILIES,
    alarms_of,
    block,
    factor_errors,
    moved_control,
    radial,
    shifted_chain,
)
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.simulation.intervals import mean_square_interval

FACTOR_RUNS, CLEAN_RUNS = 6, 12


@cache
def errors() -> dict[str, FloatArray]:
    return factor_errors(FACTOR_RUNS)


@pytest.mark.parametrize("group", ["points", "fine", "coarse"])
def test_factors_are_recovered_within_their_sigma(group: str) -> None:
    """Normalised errors of σ wrong by 0.5 and 3 have mean 0 and mean square 1."""
    e = errors()[group]
    assert len(e) == FACTOR_RUNS
    assert abs(e.mean()) < 2.81 / np.sqrt(len(e))
    low, high = mean_square_interval(len(e))
    assert low < float(np.mean(e**2)) < high


@cache
def clean() -> list[frozenset[str]]:
    return [alarms_of(adjust(block(seed))) for seed in range(1001, 1001 + CLEAN_RUNS)]


@pytest.mark.parametrize("family", FAMILIES)
def test_false_alarms_do_not_exceed_their_level(family: str) -> None:
    """Of alpha = 0.05 in 12 clean blocks: at most 3 with 99.8 %."""
    most = int(binom.ppf(0.997, CLEAN_RUNS, 0.05))
    assert sum(family in found for found in clean()) <= most


def test_planted_effects_are_found_by_their_own_test() -> None:
    """Effects of eight and more of their σ: missed with less than 1e-4."""
    network = block(1)
    assert "radial trend" in alarms_of(adjust(radial(network, 120.0)))
    assert "groups" in alarms_of(adjust(shifted_chain(network, 25.0)))
    assert "groups" in alarms_of(adjust(moved_control(network, 0.3)))
