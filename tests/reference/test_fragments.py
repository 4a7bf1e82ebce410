"""Strasbourg and vase without labels and shapes: links of the fragments against the labels.

Sources as in reference/README.md.  Links to another label count as wrong where the point is farther than three sigma
from the labelled curve: image 9111 of Strasbourg shows two roof edges as one line.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.fragment_figures import FragmentFigures, figures
from benchmarks.wrong_chains import with_wrong_chains
from splinebba_cli.core.matching.fragments.build import build_fragments
from splinebba_cli.core.network import Network
from tests.reference_data import strasbourg_curves_network, vase_network
from tests.unlabelled import without_labels


def figures_of(network: Network, wrong_share: float) -> FragmentFigures:
    """Held against the reference curves (their knots)."""
    bare, truth = without_labels(replace(network, curves=()))
    mixed, wrong = with_wrong_chains(bare, wrong_share)
    labels = np.concatenate([truth, np.full(len(wrong), -1)])
    fragments = build_fragments(mixed, mixed.images.rotation, mixed.images.position)
    return figures(mixed, fragments, labels, [curve.values for curve in network.curves])


@pytest.mark.parametrize(("name", "wrong_share"), [("strasbourg", 0.0), ("strasbourg", 0.3), ("vase", 0.3)])
def test_all_curves_are_found_and_links_are_right(name: str, wrong_share: float) -> None:
    network = strasbourg_curves_network() if name == "strasbourg" else vase_network()
    found = figures_of(network, wrong_share)
    assert found.curves == len(network.curves)
    assert found.false_fragments == 0
    assert found.right_share >= 0.99
    assert found.covered >= 0.93
