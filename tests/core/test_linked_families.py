"""Arc lengths and tangents on curves of other families than natural splines: the truth comes back from wrong starts.

Closed ones too: arcs follow the locations inside one turn.
"""

from __future__ import annotations

import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.simulation.linked_observations import with_arc_lengths, with_tangents
from tests.core.family_features import ALL
from tests.core.free_curves import block_with
from tests.core.test_recovery_of_families import TOLERANCE, distance_from_truth

NAMES = (
    "conic",
    "circle",
    "arc",
    "circular-arc",
    "fourier",
    "cardinal",
    "bspline_3",
    "bspline_2-closed",
    "cubics-3--1",
    "cubics-3-1",
)
SIGMA_MM, SIGMA_RAD = 0.005, 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_arc_lengths_and_tangents(name: str) -> None:
    feature = next(one for one in ALL if one.id == name)
    network, truth = block_with(feature, fixed=True, noise_um=0.0, per_curve=20)
    network = with_tangents(with_arc_lengths(network, truth, SIGMA_MM, None), truth, SIGMA_RAD, None)
    assert len(network.arc_lengths) and len(network.tangents)
    result = adjust(network)
    assert result.statistics.vtpv < 1e-9
    assert distance_from_truth(feature, result.curves[0].sample_xyz) < TOLERANCE
    redundancy = result.statistics.redundancy
    assert result.statistics.sum_redundancy_numbers == pytest.approx(redundancy, abs=1e-3)
