"""Knots that follow need: insertion where a curve cannot follow, removal where nothing supports it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.curve_refinement import refine_curves
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.curves.support import supported_knots
from splinebba_cli.core.network import KnotPolicy, Network
from splinebba_cli.core.observations.location_search import squared_distance
from splinebba_cli.core.state import prepare
from tests.core.free_curves import WINDING, block_with, tie


def refined(network: Network, policy: KnotPolicy) -> tuple[int, float]:
    """Number of knots and whitened rms distance after the curves are refined with the true orientations held."""
    network = replace(network, settings=replace(network.settings, knots=policy))
    prepared = prepare(network)
    prepared, state = refine_curves(prepared, starting_state(prepared)[0], None)
    return prepared.curves.coefficient_count, float(np.sqrt(np.mean(squared_distance(prepared, state))))


def test_insertion_brings_the_residuals_down() -> None:
    """A winding spline with knots too far apart to follow it, with and without insertion."""
    network, _ = block_with(tie("road", "natural_cubic", WINDING), fixed=True, per_curve=30)
    length = float(np.linalg.norm(np.diff(network.curves[0].values, axis=0), axis=1).sum())
    coarse = KnotPolicy(spacing_m=length / 2.0)
    knots, residual = refined(network, coarse)
    more_knots, smaller_residual = refined(network, replace(coarse, insert=True))
    assert more_knots > knots
    assert smaller_residual < 0.5 * residual


def test_poor_segments_are_joined_with_their_poorer_neighbour() -> None:
    np.testing.assert_array_equal(supported_knots(np.array([9, 1, 5, 9]), closed=False), [0, 1, 3, 4])
    np.testing.assert_array_equal(supported_knots(np.array([9, 9, 9]), closed=False), [0, 1, 2, 3])


def test_empty_ends_are_cut_off_or_joined() -> None:
    number = np.array([0, 9, 9, 0])
    np.testing.assert_array_equal(supported_knots(number, closed=False), [1, 2, 3])
    np.testing.assert_array_equal(supported_knots(number, closed=False, cut_ends=False), [0, 2, 4])


def test_a_closed_curve_keeps_three_knots() -> None:
    assert len(supported_knots(np.array([0, 1, 2, 3, 2]), closed=True)) == 3
