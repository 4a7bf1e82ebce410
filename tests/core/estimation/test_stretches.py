"""Stretches of curves: what is decided for one of them touches no other, and short curves are one each."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from benchmarks.coastline_block import Coastline, coastline_network
from splinebba_cli.core.approximation.starting_values import starting_state
from splinebba_cli.core.estimation import stretches as stretches_module
from splinebba_cli.core.estimation.damping import Damping
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.estimation.stretches import Stretches, curve_costs, stretch_costs
from splinebba_cli.core.observations.coefficient_rows import gauge_rows
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.six_image_block import simulate_block


@pytest.fixture(autouse=True)
def _short_curves_are_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Curves of a few nodes are divided as well."""
    monkeypatch.setattr(stretches_module, "LONG", 1)


@cache
def coast() -> tuple[Assembler, Linearization, Stretches]:
    """A tie coast of 40 knots: ten stretches of four coefficients."""
    prepared = prepare(coastline_network(Coastline(40, role="tie")))
    layout = layout_of(prepared)
    assembler = Assembler(prepared, layout, gauge_rows(prepared, layout.coefficient_mask, None))
    state = search_locations(prepared, starting_state(prepared)[0])
    at = assembler.linearize(state, held_locations(prepared, state.location))
    return assembler, at, Stretches.of(layout, prepared.curves)


def chosen(count: int, *numbers: int) -> np.ndarray:
    flags = np.zeros(count, dtype=bool)
    flags[list(numbers)] = True
    return flags


def test_a_short_curve_is_one_stretch() -> None:
    prepared = prepare(simulate_block("six-image-mixed", seed=1)[0])
    stretches = Stretches.of(layout_of(prepared), prepared.curves)
    assert stretches.whole.all()
    assert stretches.curve.tolist() == list(range(len(prepared.curves.bases)))
    observed = prepared.network.curve_observations
    assert (stretches.of_points(observed.curve, np.zeros(len(observed))) == observed.curve).all()
    alone = chosen(len(stretches.curve), 0)
    assert (stretches.with_neighbours(alone) == alone).all()


def test_a_long_curve_is_a_chain_of_them() -> None:
    assembler, at, stretches = coast()
    assert stretches.curve.tolist() == [0] * 10
    of_segments = stretches.of_segments()
    assert (np.diff(of_segments) >= 0).all()
    assert set(of_segments.tolist()) == set(range(10))
    observed = assembler.prepared.network.curve_observations
    segment = assembler.prepared.curves.locate(observed.curve, at.state.location)[0]
    assert (stretches.of_points(observed.curve, at.state.location) == of_segments[segment]).all()
    assert np.flatnonzero(stretches.with_neighbours(chosen(10, 0, 5))).tolist() == [0, 1, 4, 5, 6]


def test_their_costs_are_those_of_the_curve() -> None:
    assembler, at, stretches = coast()
    before, after = stretch_costs(assembler, stretches, at, at)
    assert (before == after).all()
    assert (before > 0.0).all()
    np.testing.assert_allclose(before.sum(), curve_costs(assembler, at).sum(), rtol=1e-12)


def test_damping_of_a_stretch_is_on_its_coefficients_alone() -> None:
    assembler, at, _ = coast()
    damping = Damping.starting(assembler, 0.0).raised(chosen(10, 3))
    extra = damping.of_unknowns(assembler, at)
    assert extra is not None
    layout = assembler.layout
    unknowns = layout.unknown_of_coefficient[12:16, None] + np.arange(3)
    assert set(np.flatnonzero(extra).tolist()) == set(unknowns.ravel().tolist())
    assert damping.everywhere == 0.0


def test_curves_of_usual_length_are_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stretches_module, "LONG", 32)
    assembler, _, _ = coast()
    stretches = Stretches.of(assembler.layout, assembler.prepared.curves)
    assert len(stretches.curve) == len(assembler.prepared.curves.bases)
    assert stretches.whole.all()
    values = stretches.of_unknowns(np.arange(1.0, len(stretches.curve) + 1))
    curve = np.repeat(assembler.layout.node_curve, assembler.layout.node_sizes)
    assert np.array_equal(values, np.where(curve >= 0, curve + 1.0, 0.0))
