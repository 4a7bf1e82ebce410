"""Foot points: r . r' = 0, the nearest of all places of the projected curve, and locations held at their bounds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.observations.curve_points import linearize_curve_points
from splinebba_cli.core.observations.location_search import search_locations, squared_distance
from splinebba_cli.core.observations.locations import held_locations, location_bounds, refine_locations
from splinebba_cli.core.observations.projected_places import projected_derivatives
from splinebba_cli.core.state import Prepared, State, initial_coefficients, prepare
from tests.core.free_curves import CUBIC, LINE, STRAIGHT, WINDING, block_with, tie
from tests.core.observations import complex_step
from tests.core.observations.random_network import random_case

SAMPLES = 4001
HAIRPIN = np.array([[3150.0, 4200.0, 40.0], [900.0, 60.0, 10.0], [-2400.0, 60.0, 0.0], [1700.0, -20.0, 0.0]])
FEATURES = (
    tie("winding", "natural_cubic", WINDING),
    tie("straight", "natural_cubic", STRAIGHT),
    tie("cubic", "free_cubic", CUBIC),
    tie("line", "straight_line", LINE),
    tie("hairpin", "free_cubic", HAIRPIN),
)


def state_of(prepared: Prepared, location: FloatArray) -> State:
    """The given values of a network."""
    images = prepared.network.images
    coefficients = initial_coefficients(prepared)
    return State(images.rotation, images.position, coefficients, prepared.network.points.xyz, location)


def derivatives(
    prepared: Prepared, state: State, rows: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """r, r' and r'' of some measured points at their locations, (k, 2) each."""
    polynomials = prepared.curves.segment_polynomials(state.coefficients)
    r, first, second = projected_derivatives(prepared, state, polynomials, rows, state.location[rows])[:3]
    return r, first, second


@cache
def scattered(spread_mm: float) -> tuple[Prepared, State]:
    """Measured points within some distance of the projected curves, locations searched."""
    network, _ = block_with(*FEATURES, fixed=True, noise_um=0.0, per_curve=15, at_the_truth=True)
    seen = network.curve_observations
    shift = np.random.default_rng(3).uniform(-spread_mm, spread_mm, seen.photo_xy.shape)
    seen = replace(seen, photo_xy=seen.photo_xy + shift, location=np.full(len(seen), np.nan))
    prepared = prepare(replace(network, curve_observations=seen))
    return prepared, search_locations(prepared, state_of(prepared, seen.location))


def dense_minimum(prepared: Prepared, state: State) -> FloatArray:
    """Smallest squared whitened distance over dense samples of everything that is allowed, (n,)."""
    seen, curves = prepared.network.curve_observations, prepared.curves
    low, high = location_bounds(prepared)
    out = np.empty(len(seen))
    for k in range(len(seen)):
        curve, image = int(seen.curve[k]), int(seen.image[k])
        u = np.linspace(low[k], high[k], SAMPLES)
        xyz = curves.evaluate(state.coefficients, np.full(len(u), curve), u)[0]
        c, rotation = np.full(len(u), prepared.principal_distance[image]), state.rotation[image]
        xy = project(c, np.broadcast_to(rotation, (len(u), 3, 3)), state.position[image][None], xyz)
        r = (xy - prepared.curve_rays.xy[k]) @ prepared.curve_rays.whitening[k].T
        out[k] = np.min(np.sum(r * r, axis=1))
    return out


def test_derivatives_of_the_projected_curve_equal_the_complex_step() -> None:
    """First and second derivative over u, whitened, for every family."""
    case = random_case()
    prepared, state = case.prepared, case.state
    network, curves = prepared.network, prepared.curves
    seen = network.curve_observations
    rows = np.arange(0, len(seen), 5)
    _, first, second = derivatives(prepared, state, rows)
    length = curves.length[curves.locate(seen.curve[rows], state.location[rows])[0]]
    for line, k in enumerate(rows):
        curve, image = int(seen.curve[k]), int(seen.image[k])
        basis, one = curves.bases[curve], network.curves[curve]
        if one.breaks:
            continue
        camera = network.cameras[network.images.camera[image]]

        def residual(
            u: complex_step.Array, k: int = int(k), image: int = image, one=one, basis=basis, camera=camera
        ):
            xyz = complex_step.curve_point(one, basis.break_points, one.values, u[0])
            computed = complex_step.photo_xy(camera, state.rotation[image], state.position[image], xyz)
            return complex_step.whitened(camera, seen.sigma[k], seen.photo_xy[k], computed)

        u, h = state.location[k : k + 1], 1e-4 * length[line]
        exact = complex_step.jacobian(residual, u)[:, 0]
        np.testing.assert_allclose(first[line], exact, rtol=0.0, atol=1e-9 * np.abs(exact).max(initial=1e-12))
        # complex step in the first order, fourth-order differences in the second: errors of h^4 = 1e-16 relative,
        # rounding 1e-16 / 1e-4
        at = [complex_step.jacobian(residual, u + step * h)[:, 0] for step in (-2.0, -1.0, 1.0, 2.0)]
        numeric = (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3]) / (12.0 * h)
        inside = np.ptp([curves.locate(seen.curve[k : k + 1], u + s * h)[0][0] for s in (-2, 2)]) == 0
        if inside:
            size = np.abs(numeric).max() + np.abs(exact / length[line]).max()
            np.testing.assert_allclose(second[line], numeric, rtol=0.0, atol=1e-9 * size)


@pytest.mark.parametrize("spread_mm", [0.01, 1.0, 8.0])
def test_the_residual_is_normal_to_the_curve(spread_mm: float) -> None:
    """r . r' = 0: along the curve less than a millionth of sigma, wherever the location is not held."""
    prepared, state = scattered(spread_mm)
    held = held_locations(prepared, state.location)
    rows = np.setdiff1d(np.arange(len(state.location)), held)
    assert len(rows) > 0.9 * len(state.location)
    r, first, second = derivatives(prepared, state, rows)
    speed = np.linalg.norm(first, axis=1)
    assert np.abs(np.sum(r * first, axis=1) / speed).max() < 1e-6
    hessian = speed**2 + np.sum(r * second, axis=1)
    assert (hessian > 0.0).all()  # a minimum


@pytest.mark.parametrize("spread_mm", [0.01, 1.0, 8.0])
def test_no_other_place_of_the_curve_is_nearer(spread_mm: float) -> None:
    """Against 4001 samples of all that is allowed; 8 mm are 25 m on the ground, more than the radius of the bends."""
    prepared, state = scattered(spread_mm)
    found, dense = squared_distance(prepared, state), dense_minimum(prepared, state)
    assert (found <= dense * (1.0 + 1e-9) + 1e-9).all(), np.flatnonzero(found > dense * (1.0 + 1e-9) + 1e-9)


def test_refinement_finds_the_neighbouring_foot_point() -> None:
    """From locations off by a tenth of a segment back to the same ones."""
    prepared, state = scattered(0.01)
    moved = replace(
        state, location=state.location + np.random.default_rng(2).uniform(-0.1, 0.1, len(state.location))
    )
    again = refine_locations(prepared, moved, 30)
    speed = np.linalg.norm(derivatives(prepared, state, np.arange(len(state.location)))[1], axis=1)
    assert np.abs((again.location - state.location) * speed).max() < 1e-6


def test_a_search_never_makes_it_worse() -> None:
    prepared, state = scattered(1.0)
    better = replace(state, location=refine_locations(prepared, state).location)
    again = search_locations(prepared, better)
    before, after = squared_distance(prepared, better), squared_distance(prepared, again)
    # coordinates of some thousand metres: 1e-12 m of rounding are 1e-10 sigma in the photo
    assert (after <= before + 2e-10 * np.sqrt(before)).all()


def bound(segment: int) -> tuple[Network, Prepared, State]:
    """All points of the winding spline bound to one segment."""
    network, _ = block_with(FEATURES[0], fixed=True, noise_um=0.0, per_curve=15, at_the_truth=True)
    seen = network.curve_observations
    seen = replace(seen, segment=np.full(len(seen), segment), location=np.full(len(seen), np.nan))
    network = replace(network, curve_observations=seen)
    prepared = prepare(network)
    return network, prepared, search_locations(prepared, state_of(prepared, seen.location))


@pytest.mark.parametrize("segment", [0, 1, 3])
def test_a_given_segment_restricts_the_location(segment: int) -> None:
    """Points that lie in it keep their foot points; all others are held at one of its ends, the nearer one."""
    _, truth = block_with(FEATURES[0], fixed=True, noise_um=0.0, per_curve=15, at_the_truth=True)
    _, prepared, state = bound(segment)
    assert (state.location >= segment).all() and (state.location <= segment + 1).all()
    inside = (truth.locations > segment + 1e-6) & (truth.locations < segment + 1 - 1e-6)
    np.testing.assert_allclose(state.location[inside], truth.locations[inside], rtol=0.0, atol=1e-7)
    held = held_locations(prepared, state.location)
    assert 0 < len(held) < len(state.location)
    assert set(state.location[held]) <= {float(segment), float(segment + 1)}
    dense = dense_minimum(prepared, state)
    assert (squared_distance(prepared, state) <= dense * (1.0 + 1e-9) + 1e-9).all()


def test_held_locations_keep_the_equation_along_the_curve() -> None:
    """Both equations of a held point together are its whole residual."""
    _, prepared, state = bound(1)
    held = held_locations(prepared, state.location)
    rows = linearize_curve_points(prepared, state, held)
    count = len(state.location)
    np.testing.assert_array_equal(rows.point[count:], held)
    square = rows.residual[:count] ** 2
    square[held] += rows.residual[count:] ** 2
    np.testing.assert_allclose(square, squared_distance(prepared, state), rtol=1e-9, atol=1e-9)
    assert rows.cost == pytest.approx(float(square.sum()), rel=1e-12)


def test_open_curves_may_be_left_by_half_a_segment_and_closed_ones_wrap() -> None:
    """Bounds of open curves; a closed curve has none, and a location past its end comes in at its start."""
    case = random_case()
    prepared = case.prepared
    low, high = location_bounds(prepared)
    for number, basis in enumerate(prepared.curves.bases):
        rows = np.flatnonzero(prepared.network.curve_observations.curve == number)
        breaks = basis.break_points
        if basis.closed:
            assert np.isinf(low[rows]).all() and np.isinf(high[rows]).all()
            u = prepared.curves.wrap(
                np.full(3, number), np.array([breaks[0] - 1.0, breaks[0], breaks[-1] + 1.0])
            )
            np.testing.assert_allclose(u, [breaks[-1] - 1.0, breaks[0], breaks[0] + 1.0])
        elif not basis.has_location:
            assert (low[rows] == 0.0).all() and (high[rows] == 0.0).all()
        else:
            np.testing.assert_allclose(low[rows], breaks[0] - 0.5 * (breaks[1] - breaks[0]))
            np.testing.assert_allclose(high[rows], breaks[-1] + 0.5 * (breaks[-1] - breaks[-2]))
