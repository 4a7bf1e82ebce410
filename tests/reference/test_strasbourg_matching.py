"""Strasbourg, 30 traced curves held at their reference shape, labels removed, EOPs off by 5 m and 0.2 degrees.

The shapes were fitted with the orientations of the report held fixed (reference/README.md).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.contaminated import with_moved_orientations, with_wrong_chains
from splinebba_cli.core.matching.match import match
from splinebba_cli.core.matching.matches import MatchResult
from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.core.network import IntArray, Network
from tests.reference_data import STRASBOURG_PIXEL_MM, reference_dir, strasbourg_curves_network
from tests.unlabelled import without_labels

pytestmark = pytest.mark.skipif(
    not (reference_dir() / "strasbourg_aerial").is_dir(), reason="reference data are not there"
)
POSITION_M, ANGLE_RAD = 5.0 / np.sqrt(3.0), float(np.radians(0.2)) / np.sqrt(3.0)


def start(seed: int) -> tuple[Network, Network, IntArray]:
    """At the reference orientations; unlabelled with a wrong start; the labels."""
    traced = strasbourg_curves_network(points=False)
    curves = tuple(replace(c, role="control", sigma=np.zeros_like(c.values)) for c in traced.curves)
    exact = replace(traced, curves=curves)
    network, label = without_labels(exact)
    generator = np.random.default_rng(seed)
    return exact, with_moved_orientations(network, generator, POSITION_M, ANGLE_RAD), label


def matched(network: Network) -> MatchResult:
    return match(network, MatchSettings(position_sigma_m=POSITION_M, angle_sigma_rad=ANGLE_RAD))


@pytest.fixture(scope="module")
def found() -> tuple[MatchResult, IntArray, Network]:
    exact, network, label = start(1)
    return matched(network), label, exact


def test_labels_are_recovered(found: tuple[MatchResult, IntArray, Network]) -> None:
    result, label, _ = found
    assert np.mean(result.matches.curve == label) >= 0.97
    assert np.mean((result.matches.curve >= 0) & (result.matches.curve != label)) < 0.001


def test_orientations_agree_with_the_report(found: tuple[MatchResult, IntArray, Network]) -> None:
    """Within 4 sigma: edges have errors of their own, in common to their points, which sigma do not hold."""
    result, _, exact = found
    sigma = np.sqrt(np.einsum("mii->mi", result.eop_dispersion))[:, 3:]
    assert result.oriented.all()
    assert (np.abs(result.network.images.position - exact.images.position) < 4.0 * sigma).all()


def test_wrong_chains_change_little(found: tuple[MatchResult, IntArray, Network]) -> None:
    """30 % of the chains are copies turned by up to 30 degrees and moved by up to 50 px; another start.

    Edges have errors of their own: a curve more or less at its margin moves an image by more than its sigma.
    """
    clean, _, _ = found
    _, network, label = start(2)
    network, label = with_wrong_chains(
        network, label, 0.3, np.random.default_rng(2), 50.0 * STRASBOURG_PIXEL_MM
    )
    result = matched(network)
    on_curve = label >= 0
    assert np.mean((result.matches.curve == label)[on_curve]) >= 0.97
    assert np.mean(result.matches.curve[~on_curve] >= 0) < 0.05
    sigma = np.sqrt(np.einsum("mii->mi", clean.eop_dispersion))[:, 3:]
    moved = (result.network.images.position - clean.network.images.position) / sigma
    assert np.sqrt(np.mean(moved**2)) < 1.0
