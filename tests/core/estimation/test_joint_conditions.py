"""Gauge conditions that hold the same direction: which ones stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.estimation.gauge import jointly_needed
from splinebba_cli.core.network import FloatArray
from tests.core.family_features import HARMONICS, joined
from tests.core.free_curves import block_with, tie


def leverages(design: FloatArray, conditions: FloatArray) -> FloatArray:
    """G Q G' with Q = (A'A + G'G)^-1."""
    return np.asarray(
        conditions @ np.linalg.solve(design.T @ design + conditions.T @ conditions, conditions.T)
    )


def test_one_of_several_conditions_for_one_null_stays() -> None:
    """Four conditions see the one null of the design with different strength: the strongest is left."""
    generator = np.random.default_rng(1)
    design = generator.normal(size=(8, 4))
    null = np.array([1.0, -1.0, 0.5, 2.0])
    design -= np.outer(design @ null, null) / (null @ null)
    conditions = 1e-3 * generator.normal(size=(4, 4)) + np.outer([0.2, 0.9, 0.5, 0.1], null)
    found = leverages(design, 0.1 * conditions)
    assert np.diag(found).max() < 0.9 and np.trace(found) == pytest.approx(1.0, abs=0.1)
    assert jointly_needed(found).tolist() == [False, True, False, False]


@pytest.mark.parametrize("kept", [1, 2, 3])
def test_dropping_is_the_same_as_solving_again(kept: int) -> None:
    """The shares that the others take over: against the inverse without the dropped conditions."""
    generator = np.random.default_rng(kept)
    design = np.vstack(
        [generator.normal(size=(6, 6)) * ([1e-4] * kept + [1.0] * (6 - kept)), np.zeros((1, 6))]
    )
    conditions = generator.normal(size=(5, 6)) * ([1.0] * kept + [0.01] * (6 - kept))
    keep = jointly_needed(leverages(design, conditions))
    assert keep.sum() == kept
    assert np.diag(leverages(design, conditions[keep])).min() > 0.9


def test_what_measurements_determine_needs_no_condition() -> None:
    assert not jointly_needed(np.diag([0.3, 0.01, 0.8])).any()
    assert jointly_needed(np.eye(3)).all()


def test_fourier_curves_keep_one_phase_condition_of_five() -> None:
    network, _ = block_with(tie("fourier", "fourier", HARMONICS), fixed=True, per_curve=20)
    statistics = adjust(network).statistics
    assert (statistics.conditions, statistics.rank_defect) == (1, 1)
    assert statistics.condition_redundancy < 1e-6
    every = adjust(replace(network, settings=replace(network.settings, gauge_conditions="all"))).statistics
    assert (every.conditions, every.rank_defect) == (5, 1)
    assert every.condition_redundancy == pytest.approx(4.0, abs=0.5)


def test_conditions_of_joined_segments_fill_their_defect_together() -> None:
    """Without noise a smooth curve as C0 cubics: four directions, four conditions."""
    network, _ = block_with(joined(3, 0), fixed=True, noise_um=0.0, per_curve=20)
    statistics = adjust(network).statistics
    assert (statistics.conditions, statistics.rank_defect) == (4, 4)
