"""Variances of residuals for any factor of the weight, against dense algebra; predictions without the observation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import Distances, FloatArray, Network
from splinebba_cli.core.revision.observation_list import CURVES, ObservationList
from splinebba_cli.core.revision.weighted_solution import WeightedNetwork, WeightedSolution
from splinebba_cli.core.state import prepare
from tests.core.small_networks import dense_system, mixed_network, solved


def network_of_everything() -> Network:
    """Without the distances, which contradict the rest: the iterations then end where steps are negligible."""
    return replace(mixed_network()[0], distances=Distances.none())


def weighted(factors: dict[int, float]) -> tuple[WeightedSolution, ObservationList]:
    """A small network of everything, solved with factors of single entries of its list."""
    network = network_of_everything()
    start = solved(network)
    everything = WeightedNetwork(prepare(network), start.solution.state, None, None)
    factor = np.ones(len(everything.listed))
    for entry, value in factors.items():
        factor[entry] = value
    found = everything.solve(factor, start.solution.state)
    assert found is not None
    return found, everything.listed


def variance_of_residual(found: WeightedSolution, row: int, factor: float) -> float:
    """Variance of v = (A Q A'P - I) e in a dense row, all e of unit variance, from the whitened design."""
    dense = dense_system(found.solved.assembler, found.solved.solution.linearization)
    root = np.ones(len(dense.design))
    root[row] = np.sqrt(factor)
    plain = dense.design / root[:, None]
    gain = np.linalg.pinv(dense.design) * root[None, :]  # Q A'P of the unweighted rows
    own: FloatArray = plain[row] @ gain
    own[row] -= 1.0
    return float(own @ own)


@pytest.mark.parametrize("factor", [1.0, 0.6, 0.05, 0.0])
def test_variance_of_a_residual_with_any_weight(factor: float) -> None:
    """Leverages of the selected inverse agree with dense ones to 1e-9; a weight of 1e-10 leaves 1e-6 of h."""
    network = network_of_everything()
    points = len(network.point_observations)
    row, entry = 33, points + 33
    found, _ = weighted({entry: factor})
    expected = variance_of_residual(found, row, max(factor, 1e-10))
    residual = found.statistics.residual[entry, 0]
    w = found.statistics.standardized[entry, 0]
    assert (residual / w) ** 2 == pytest.approx(expected, rel=1e-5)


def test_prediction_is_that_of_the_network_without_the_observation() -> None:
    """v and w of a point that is out, from a network in which it is not: its foot point and the dispersion there."""
    network = network_of_everything()
    row, points = 40, len(network.point_observations)
    found, listed = weighted({points + row: 0.0})
    flags = np.zeros(len(network.curve_observations), dtype=bool)
    flags[row] = True
    gone = replace(network, curve_observations=replace(network.curve_observations, excluded=flags))
    gone = replace(gone, settings=replace(gone.settings, gauge_conditions="all"))
    result = adjust(gone)
    assert result.statistics.redundancy == pytest.approx(found.statistics.redundancy, abs=1e-5)
    assert listed.name(points + row).startswith("image")
    across = found.statistics.residual[points + row, 0] * network.curve_observations.sigma[row, 0]
    assert result.curve_residuals.across[row] == pytest.approx(across, abs=1e-6 * 5e-3 * 10)
    w = found.statistics.standardized[points + row, 0]
    assert result.curve_residuals.standardized[row, 0] == pytest.approx(w, rel=1e-5)
    assert result.curve_residuals.redundancy[row].tolist() == [0.0, 0.0]
    assert found.statistics.residual.shape == (len(listed), 2)
    assert listed.part(found.factor, CURVES)[row] == 0.0


def test_w_of_an_observation_is_that_of_its_prediction() -> None:
    """v_i / (sigma sqrt(r)) = (v_i / r) / (sigma sqrt(1 / r)) up to the curvature of the model; sigma0 changes too."""
    network = network_of_everything()
    points = len(network.point_observations)
    within, _ = weighted({})
    tested = np.flatnonzero(np.isfinite(within.statistics.standardized[points:, 0]))
    for row in tested[[20, 120]]:
        out, _ = weighted({points + int(row): 0.0})
        w = within.statistics.standardized[points + row, 0]
        assert out.statistics.standardized[points + row, 0] == pytest.approx(w, rel=0.02, abs=0.01)
        assert out.statistics.redundancy == pytest.approx(within.statistics.redundancy - 1.0, abs=1e-5)
