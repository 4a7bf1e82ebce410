"""Reweighted adjustments: the weights are those of their own residuals, errors lose theirs, and it is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blunder_cases import largest_shift, with_policy
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.revision.observation_list import ObservationList
from splinebba_cli.core.revision.reweighting import SETTLED, one_value
from splinebba_cli.core.revision.robust_weights import WEIGHT_FUNCTIONS
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork
from splinebba_cli.core.settings import OutlierMethod, OutlierPolicy
from splinebba_cli.core.state import State, prepare
from tests.core.revision.test_data_snooping import ROWS, clean, planted

METHODS: tuple[OutlierMethod, ...] = ("huber", "cauchy", "tukey", "danish")


@pytest.mark.parametrize("method", METHODS)
def test_errors_lose_their_weight_and_orientations_are_kept(method: OutlierMethod) -> None:
    """Shift below 2 σ: the efficiency of 95 % alone moves an estimate by sqrt(1 / 0.95 - 1) = 0.23 σ; 36 elements."""
    result = adjust(with_policy(planted(), OutlierPolicy(method)))
    weights = result.revision.curve_weights
    assert weights is not None
    assert (weights[ROWS] < 0.1).all()
    assert np.median(weights) > 0.8
    assert largest_shift(clean().result, result) < 2.0
    assert result.statistics.sum_redundancy_numbers == pytest.approx(result.statistics.redundancy, abs=1e-6)
    assert not any(p.code == "SBB542" for p in result.problems)
    assert (result.network.curve_observations.sigma == 0.005).all()


@pytest.mark.parametrize("method", ["huber", "tukey"])
def test_the_weights_are_those_of_the_residuals_that_they_give(method: OutlierMethod) -> None:
    """The fixed point: one more round changes no weight by much more than the limit of the iterations."""
    result = adjust(with_policy(planted(), OutlierPolicy(method)))
    network, revision = result.network, result.revision
    assert revision.curve_weights is not None and revision.point_weights is not None
    factor = np.concatenate([revision.point_weights, revision.curve_weights])
    state = State(
        result.images.rotation,
        result.images.eop[:, 3:] - network.origin,
        np.vstack([c.values for c in result.curves]) * 0.0,
        result.points.xyz - network.origin,
        result.curve_residuals.location,
    )
    prepared = prepare(network)
    own = [
        basis.coefficients_from_values(curve.values - network.origin)
        for basis, curve in zip(prepared.curves.bases, result.curves, strict=True)
    ]
    state = replace(state, coefficients=np.vstack(own))
    found = WeightedNetwork(prepared, state, np.zeros(0, dtype=np.int64), None).solve(factor, state)
    assert found is not None
    again = WEIGHT_FUNCTIONS[method](one_value(ObservationList.of(network), found.statistics, "w"))
    kept = factor > 0.0
    assert np.abs(again - factor)[kept].max() < 10.0 * SETTLED
    assert (again[~kept] < 0.05).all()


def test_redescending_weights_of_nothing_are_rejections() -> None:
    result = adjust(with_policy(planted(), OutlierPolicy("tukey")))
    log = {each.row: each for each in result.revision.rejections}
    assert set(ROWS.tolist()) <= set(log)
    assert all("of tukey" in log[int(row)].reason for row in ROWS)
    assert any(p.code == "SBB540" for p in result.problems)
    huber = adjust(with_policy(planted(), OutlierPolicy("huber")))
    assert huber.revision.rejections == ()


def test_too_few_rounds_are_reported() -> None:
    result = adjust(with_policy(planted(), OutlierPolicy("cauchy", max_rounds=1)))
    assert any(p.code == "SBB542" for p in result.problems)
