"""Rank from a factor of the normal matrix, the way of large networks, against singular values of the design."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.budget import budget
from splinebba_cli.core.estimation import rank_diagnosis
from splinebba_cli.core.network import Network
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.small_networks import select_curve_points


def block() -> Network:
    return simulate_block("six-image-mixed", seed=1)[0]


def without_control(network: Network) -> Network:
    """Nothing but tie points: seven directions are free."""
    points = replace(network.points, sigma=np.full_like(network.points.sigma, np.inf))
    none = select_curve_points(network, np.zeros(0, dtype=np.int64)).curve_observations
    return replace(network, points=points, curves=(), curve_observations=none)


def test_a_regular_network_is_proved_by_one_factor(monkeypatch: pytest.MonkeyPatch) -> None:
    """No subspace iteration follows: any vector that it asked for would fail."""
    expected = budget(block())
    monkeypatch.setattr(rank_diagnosis, "DENSE_LIMIT", 0)
    monkeypatch.setattr(rank_diagnosis, "EIGEN_ZERO", np.inf)  # would call every vector a null
    found = budget(block())
    assert (found.rank, found.nullity) == (expected.rank, 0)


def test_the_datum_of_a_free_network(monkeypatch: pytest.MonkeyPatch) -> None:
    network = without_control(block())
    expected = budget(network)
    monkeypatch.setattr(rank_diagnosis, "DENSE_LIMIT", 0)
    found = budget(network)
    assert expected.nullity == 7
    assert (found.rank, found.nullity) == (expected.rank, 7)
