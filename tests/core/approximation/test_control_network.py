"""Orientations from control splines alone: what is taken of a network, and from how far it comes back."""

from __future__ import annotations

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.approximation.control_network import control_network, known_curves
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from splinebba_cli.simulation.six_image_block import simulate_block


def test_control_splines_with_all_that_is_measured_on_them() -> None:
    network, truth = simulate_block("six-image", seed=1)
    network = with_tangents(with_arc_lengths(network, truth, 0.007, None), truth, 0.01, None)
    part, rows = control_network(network)
    assert [curve.id for curve in part.curves] == ["control-1", "control-2"]
    np.testing.assert_array_equal(part.curve_observations.photo_xy, network.curve_observations.photo_xy[rows])
    assert len(part.tangents) == len(rows)
    of_known = known_curves(network)[network.curve_observations.curve]
    assert len(part.arc_lengths) == of_known[network.arc_lengths.first].sum()
    np.testing.assert_array_equal(
        part.curve_observations.photo_xy[part.arc_lengths.second],
        network.curve_observations.photo_xy[network.arc_lengths.second[of_known[network.arc_lengths.first]]],
    )
    prepare(part)  # chains and curves fit together


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_splines_alone_from_ten_metres_and_ten_degrees(seed: int) -> None:
    """With the tie splines in it from the start none of 25 comes back from there (docs/simulation.md)."""
    network, truth = simulate_block(
        "six-image", seed, start_position_m=10.0, start_angle_deg=10.0, start_knots_m=5.0
    )
    result = adjust(network)
    stages = {iteration.stage for iteration in result.iterations}
    assert stages == {"control", "joint"}
    sigma = np.sqrt(np.einsum("mii->mi", result.images.dispersion))[:, 3:]
    assert np.abs((result.images.eop[:, 3:] - truth.eop[:, 3:]) / sigma).max() < 5.0
