"""Normal equations of curve points by windows of images and blocks, against the products of their rows."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from splinebba_cli.core import speed
from splinebba_cli.core.estimation import curve_windows
from splinebba_cli.core.estimation.curve_blocks import CurveBlocks
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import ParameterLayout, layout_of
from splinebba_cli.core.estimation.segment_windows import add_segment_windows
from splinebba_cli.core.matching.labelled_network import with_labels
from splinebba_cli.core.network import Curve, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows
from splinebba_cli.core.observations.curve_points import linearize_curve_points
from splinebba_cli.core.observations.location_search import search_locations
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare
from tests.core.matching.known_curves.one_image import MIDDLE, network, seen
from tests.core.observations.random_network import random_case
from tests.core.small_networks import mixed_network, start_of

MODES = ["never", "always"]


def with_long_curves(network: Network) -> Network:
    """Every tie spline with many more knots: chains of several nodes, open and closed."""
    curves = tuple(finer(curve, 5) if curve.family == "natural_cubic" else curve for curve in network.curves)
    seen = network.curve_observations
    return replace(network, curves=curves, curve_observations=replace(seen, location=seen.location * np.nan))


def finer(curve: Curve, times: int) -> Curve:
    """The same polygon of knots with `times` segments in place of each."""
    ends = np.concatenate([curve.values, curve.values[:1]]) if curve.closed else curve.values
    places = np.arange(times * (len(ends) - 1) + 1) / times
    values = np.stack([np.interp(places, np.arange(len(ends)), ends[:, d]) for d in range(3)], axis=1)
    values = values[:-1] if curve.closed else values
    held = np.zeros((len(values), 3)) if (curve.sigma == 0.0).all() else np.full((len(values), 3), np.inf)
    return replace(curve, values=values, sigma=held, knot_parameters=None, breaks=(), reference=None)


@cache
def networks() -> dict[str, tuple[Prepared, State]]:
    mixed = mixed_network()[0]
    long = with_long_curves(mixed)
    prepared = prepare(long)
    every = random_case()
    return {
        "mixed": (prepare(mixed), start_of(mixed)),
        "long curves": (prepared, search_locations(prepared, start_of(long))),
        "every family, no foot points": (every.prepared, every.state),
    }


def assembled(prepared: Prepared, state: State, layout: ParameterLayout) -> tuple[Assembler, Linearization]:
    assembler = Assembler(prepared, layout, concatenate_rows([], prepared.curves.support))
    return assembler, assembler.linearize(state, held_locations(prepared, state.location))


def without_curves(
    prepared: Prepared, at: Linearization, assembler: Assembler
) -> tuple[FloatArray, FloatArray]:
    """What curve points add: the equations minus those with all rows of curve points at infinite sigma."""
    blunt = replace(prepared.curve_rays, whitening=np.zeros_like(prepared.curve_rays.whitening))
    other = assembler.with_weights(replace(prepared, curve_rays=blunt))
    rest = other.linearize(at.state, at.held_locations)
    return at.base_values - rest.base_values, at.base_side - rest.base_side


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("orientations", ["free", "held"])
@pytest.mark.parametrize("name", ["mixed", "long curves", "every family, no foot points"])
def test_products_of_the_rows(
    name: str, orientations: str, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if mode == "always":
        pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, mode)
    monkeypatch.setattr(curve_windows, "CHUNK_POINTS", 60)  # many chunks
    prepared, state = networks()[name]
    layout = layout_of(prepared)
    assembler, at = assembled(prepared, state, layout if orientations == "free" else layout.hold_images())
    values, side = np.zeros_like(at.base_values), np.zeros_like(at.base_side)
    add_segment_windows(at.curve_jacobian, at.windows, prepared.curves, at.layout, values, side)
    found, found_side = without_curves(prepared, at, assembler)
    scale = np.abs(values).max()
    removed = assembler.mask == 0.0
    assert np.abs(found - values).max() < 1e-12 * scale
    assert np.abs((found_side - side)[~removed]).max() < 1e-11 * np.abs(side).max()
    squares = np.sum(at.curve_jacobian[:, -1] ** 2)
    assert float(at.on_curves.squares.sum()) == pytest.approx(squares, rel=1e-12)


def test_a_long_curve_has_a_block_for_every_node() -> None:
    prepared, _ = networks()["long curves"]
    layout = layout_of(prepared)
    blocks = CurveBlocks.of(prepared.curves, layout)
    segments = np.flatnonzero(blocks.of_segment >= 0)
    assert len(blocks) > 2 * len(prepared.curves.bases)
    own = blocks.columns[blocks.of_segment[segments]]
    for slot in range(prepared.curves.support):
        assert (own == prepared.curves.columns[segments, slot][:, None]).any(axis=1).all()
    t = np.random.default_rng(3).uniform(0.0, 1.0, len(segments))
    powers = t[:, None] ** np.arange(4)
    weights = np.einsum("sk,skb->sb", powers, blocks.weights[segments])
    by_block = np.einsum("sb,sbd->sd", weights, networks()["long curves"][1].coefficients[own])
    local = networks()["long curves"][1].coefficients[prepared.curves.columns[segments]]
    direct = np.einsum("sw,swd->sd", prepared.curves.weights(segments, t), local)
    np.testing.assert_allclose(by_block, direct, rtol=1e-12)


def test_the_sums_do_not_depend_on_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(speed.VARIABLE, "never")
    monkeypatch.setattr(curve_windows, "CHUNK_POINTS", 60)
    prepared, state = networks()["mixed"]
    found = []
    for count in ("1", "3"):
        monkeypatch.setenv("SPLINEBBA_THREADS", count)
        at = assembled(prepared, state, layout_of(prepared))[1]
        found.append((at.base_values, at.base_side))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])


@pytest.mark.parametrize("mode", MODES)
def test_a_point_behind_the_camera(mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if mode == "always":
        pytest.importorskip("numba")
    monkeypatch.setenv(speed.VARIABLE, mode)
    prepared, state = networks()["mixed"]
    below = state.position.copy()
    below[1, 2] = -500.0
    with pytest.raises(FloatingPointError, match="behind a camera"):
        assembled(prepared, replace(state, position=below), layout_of(prepared))


def test_locations_cross_between_segments_that_share_no_coefficient() -> None:
    """Such a curve has many blocks, none of which shares a node: the pattern must still follow the locations."""
    u = np.linspace(0.0, 2.0, 41)
    way = np.column_stack([200.0 * u - 200.0, 30.0 * np.sin(3.0 * u), 5.0 * u]) + MIDDLE
    spline, step = CubicSpline(u, way), float(u[1])
    powers = np.stack([spline.c[3 - k] * step**k for k in range(4)], axis=1).reshape(-1, 3)
    curve = Curve("c", "control", "polynomial_3", powers, np.zeros_like(powers), knot_parameters=u)
    given = network([curve], [seen(curve, 60, 0.1, 0.9)])
    prepared = prepare(with_labels(given, np.zeros(60, dtype=np.int64), np.linspace(0.2, 1.8, 60)))
    state = State(
        given.images.rotation, given.images.position, initial_coefficients(prepared), np.zeros((0, 3)),
        prepared.network.curve_observations.location,
    )  # fmt: skip
    layout = layout_of(prepared)
    assembler = Assembler(prepared, layout, concatenate_rows([], prepared.curves.support))
    for shift in (0.0, 0.6 * step, -0.7 * step):
        moved = replace(state, location=state.location + shift)
        at = assembler.linearize(moved, held_locations(prepared, moved.location))
        exact = linearize_curve_points(prepared, moved, np.zeros(0, dtype=np.int64))
        np.testing.assert_allclose(np.abs(at.on_curves.across), np.abs(exact.residual[:60]), atol=1e-9)
