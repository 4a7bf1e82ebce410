"""Planted gross errors, short ``python -m benchmarks.blunders``; figures: docs/outliers.md.

Every interval is the one in which a correct program finds its count with 99 % probability (binomial).
"""

from __future__ import annotations

import os

import numpy as np
import pytest

from benchmarks.blunders import false_rejections, first_rejections, shifts

LONG = pytest.mark.skipif(os.environ.get("SPLINEBBA_LONG") != "1", reason="SPLINEBBA_LONG=1 runs it")


@pytest.mark.parametrize("runs", [20, pytest.param(200, marks=LONG)])
def test_an_error_of_six_sigma_is_rejected_first_as_often_as_its_design_predicts(runs: int) -> None:
    found = first_rejections(runs)
    low, high = found.interval
    assert low * runs <= found.observed <= high * runs, found


@pytest.mark.parametrize(("share", "runs"), [(0.2, 6), pytest.param(0.4, 100, marks=LONG)])
def test_gross_errors_in_curve_points_do_not_move_the_orientations(share: float, runs: int) -> None:
    """Within 3 σ of the solution without errors in 95 % of the runs; six of six where that holds with 99.9 % each."""
    found = shifts(share, runs, "six-image-mixed")
    assert np.isfinite(found.found).all()
    assert found.within >= 0.95, found


@pytest.mark.parametrize(("runs", "needed"), [(4, 2), pytest.param(30, 24, marks=LONG)])
def test_two_in_five_errors_on_splines_alone(runs: int, needed: int) -> None:
    """Within 3 σ in 93 % of 30 runs: two of four have a probability of 0.9987, 24 of 30 one of 0.99."""
    found = shifts(0.4, runs, "six-image")
    assert np.isfinite(found.found).all()
    assert (found.found <= 3.0).sum() >= needed, found


@pytest.mark.parametrize("runs", [10, pytest.param(200, marks=LONG)])
def test_without_errors_tests_reject_their_alpha(runs: int) -> None:
    found = false_rejections(runs)
    low, high = found.interval
    assert low <= found.beyond / found.tests <= high, found
