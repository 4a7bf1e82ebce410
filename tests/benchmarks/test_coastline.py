"""A coastline as one long spline: right, and at a cost that is proportional to its length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks.coastline_block import Coastline, coastline_network, measured_coastline
from benchmarks.peer_rule import squared_distance
from benchmarks.solve_block import assembler_of
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation.block_cholesky import SymbolicFactor
from splinebba_cli.core.network import Role
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations, refine_locations
from splinebba_cli.core.state import prepare


@pytest.mark.parametrize("role", ["partial", "tie"])
def test_the_strip_is_adjusted_to_its_noise(role: Role) -> None:
    """v'Pv is chi-square with the redundancy r as degrees of freedom: outside with probability 1e-4."""
    coast = Coastline(60, role=role, points_per_image=60)
    network = coastline_network(coast)
    assert len(network.images.ids) == coast.images == 10
    result = adjust(network)
    assert result.converged
    statistics = result.statistics
    square = statistics.redundancy * statistics.sigma0**2
    assert chi2.ppf(5e-5, statistics.redundancy) < square < chi2.ppf(1.0 - 5e-5, statistics.redundancy)


def test_an_image_sees_its_part_of_the_coast() -> None:
    coast = Coastline(200)
    seen = coastline_network(coast).curve_observations
    # most candidates of 25 knots lie in the format; overlap 75 %: four images see a knot
    assert 0.85 * coast.points_per_image < len(seen) / coast.images <= coast.points_per_image


def test_the_search_along_a_long_coast_finds_the_nearest_place() -> None:
    """Of every measured point a place at least as near as the one next to the truth.

    Newton's method ends within 1e-10 sigma of a foot point; the square of a distance of some 100 sigma (knots are
    off by a metre) is exact to 1e-8.
    """
    network, location = measured_coastline(Coastline(150, points_per_image=40))
    prepared = prepare(network)
    state, _ = starting_state(prepared)
    found = search_locations(prepared, state)
    near_truth = refine_locations(prepared, replace(state, location=location))
    assert np.max(squared_distance(prepared, found) - squared_distance(prepared, near_truth)) < 1e-7
    # a metre is 0.012 of the distance of knots
    assert np.max(np.abs(found.location - location)) < 0.1


def factor_of(knots: int) -> SymbolicFactor:
    """Pattern and ordering of a coast."""
    network, location = measured_coastline(Coastline(knots))
    prepared = prepare(network)
    state = replace(starting_state(prepared)[0], location=location)
    assembler = assembler_of(prepared, state)
    assembler.linearize(state, held_locations(prepared, state.location))
    return assembler.symbolic(state)


def test_factor_of_a_long_coast_is_proportional_to_its_length() -> None:
    """A strip is cut by separators of constant size: four times the knots, four times entries and operations.

    Boundary effects of the short one and the choice of leaves may change them by half; without such separators
    operations a knot grow at least fourfold.
    """
    short, long = factor_of(120), factor_of(480)
    assert long.structure.n_entries / short.structure.n_entries == pytest.approx(4.0, rel=0.1)
    assert long.factor_entries < 1.5 * 4.0 * short.factor_entries
    assert long.flops < 2.0 * 4.0 * short.flops
    fronts = [max(factor.unknowns_of_fronts) for factor in (short, long)]
    assert fronts[1] < 2.0 * fronts[0]
    assert np.max(fronts) < 400  # images and knots of two footprints: 2 (4 · 6 + 25 · 3) and the pivots
