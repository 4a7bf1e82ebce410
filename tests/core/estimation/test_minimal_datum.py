"""A free block: the same residuals and similar results whichever images carry the datum (theory, section 6)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.estimation.datum import minimal_datum
from splinebba_cli.core.estimation.gauss_markov import Solution, solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import Distances, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import value_rows
from splinebba_cli.core.state import prepare
from splinebba_cli.errors import SingularNetworkError
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.small_networks import start_of

CHOICES = [(0, 3, 0), (2, 5, 1), (4, 1, 1), (5, 0, 1)]  # image held, image of the scale, its coordinate


@cache
def free_network() -> Network:
    """Tie points and tie splines alone."""
    network, _ = simulate_block(
        "six-image-mixed", 2, start_position_m=0.5, start_angle_deg=0.1, start_knots_m=0.3
    )
    points = network.points
    free = np.full_like(points.sigma, np.inf)
    points = replace(
        points, role=("tie",) * len(points.ids), sigma=free, xyz=np.full_like(points.xyz, np.nan)
    )
    curves = tuple(
        replace(curve, role="tie", sigma=np.full_like(curve.sigma, np.inf)) for curve in network.curves
    )
    settings = replace(network.settings, datum="minimal")
    return replace(network, points=points, curves=curves, settings=settings)


@cache
def solution_of(choice: tuple[int, int, int]) -> Solution:
    """The block with seven orientation unknowns held."""
    network = free_network()
    prepared = prepare(network)
    layout = layout_of(prepared)
    mask = layout.image_mask.copy()
    mask[choice[0]] = 0.0
    mask[choice[1], 3 + choice[2]] = 0.0
    layout = replace(layout, image_mask=mask)
    assembler = Assembler(prepared, layout, value_rows(prepared, layout.coefficient_mask))
    found = solve(assembler, start_of(network), max_iterations=50, stage="joint", damping=1e-3)
    assert found.converged, found.termination
    return found


def shape(solution: Solution) -> tuple[FloatArray, FloatArray]:
    """What a similarity leaves: ratios of the distances of stations, and rotations between images."""
    state = solution.state
    base = np.linalg.norm(state.position[:, None] - state.position[None], axis=2)
    return base / base[0, 1], np.einsum("aji,bjk->abik", state.rotation, state.rotation)


@pytest.mark.parametrize("choice", CHOICES[1:])
def test_residuals_and_shape_do_not_depend_on_the_datum(choice: tuple[int, int, int]) -> None:
    """To a thousandth of sigma: angles of 1e-5 rad and positions of 1e-5 of the distances are one."""
    first, other = solution_of(CHOICES[0]), solution_of(choice)
    assert other.linearization.cost == pytest.approx(first.linearization.cost, rel=1e-6)
    assert np.abs(other.linearization.points.residual - first.linearization.points.residual).max() < 2e-3
    assert np.abs(other.linearization.curve.residual - first.linearization.curve.residual).max() < 2e-3
    for mine, yours in zip(shape(first), shape(other), strict=True):
        assert np.abs(mine - yours).max() < 1e-6
    assert np.abs(other.state.position - first.state.position).max() > 0.05  # yet another datum


def test_the_held_unknowns_do_not_move() -> None:
    start = start_of(free_network())
    for image, scale, axis in CHOICES:
        state = solution_of((image, scale, axis)).state
        np.testing.assert_array_equal(state.position[image], start.position[image])
        np.testing.assert_array_equal(state.rotation[image], start.rotation[image])
        assert state.position[scale, axis] == start.position[scale, axis]


def test_the_adjustment_chooses_a_datum_of_its_own() -> None:
    """Seven conditions fill the defect of seven, and the variance of unit weight is that of every other choice."""
    network = free_network()
    result = adjust(network)
    statistics = result.statistics
    first = solution_of(CHOICES[0])
    gauge = statistics.conditions - 7
    assert statistics.rank_defect >= 7
    assert statistics.redundancy == statistics.observations + statistics.conditions - statistics.unknowns
    assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, abs=1e-6)
    assert gauge == 0, "this block needs no gauge conditions"
    assert statistics.vtpv == pytest.approx(first.linearization.cost, rel=1e-6)


def held_of(network: Network) -> FloatArray:
    """Number of held unknowns of every image in the minimal datum."""
    prepared = prepare(network)
    layout = minimal_datum(prepared, layout_of(prepared), start_of(network))
    return np.asarray((layout.image_mask == 0.0).sum(axis=1))


def test_as_many_unknowns_are_held_as_nothing_determines() -> None:
    network = free_network()
    assert sorted(held_of(network)) == [0, 0, 0, 0, 1, 6]
    bar = Distances(np.array([[3, 9]]), np.zeros((1, 2), dtype=bool), np.array([100.0]), np.array([0.01]))
    with_scale = replace(network, distances=bar)
    assert sorted(held_of(with_scale)) == [0, 0, 0, 0, 0, 6]
    sigma, prior = network.images.prior_sigma.copy(), network.images.prior.copy()
    sigma[1, 3:], prior[1, 3:] = 0.1, network.images.position[1]
    one_station = replace(network, images=replace(network.images, prior_sigma=sigma, prior=prior))
    assert held_of(one_station).sum() == 4  # rotation and scale
    sigma[4, 3:], prior[4, 3:] = 0.1, network.images.position[4]
    two_stations = replace(network, images=replace(network.images, prior_sigma=sigma, prior=prior))
    assert held_of(two_stations).sum() == 1  # rotation about the line of both
    xyz = network.points.xyz.copy()
    xyz[:3], control = start_of(network).xyz[:3], network.points.sigma.copy()
    control[:3, 2] = 0.05
    heights = replace(network, points=replace(network.points, sigma=control, xyz=xyz))
    assert held_of(heights).sum() == 4  # shifts in the plane, azimuth, scale


def test_nothing_is_held_where_control_fixes_the_datum() -> None:
    network = free_network()
    sigma = network.images.prior_sigma.copy()
    sigma[1:] = 0.0
    fixed = replace(network, images=replace(network.images, prior_sigma=sigma))
    assert (held_of(fixed) == [0, 6, 6, 6, 6, 6]).all()


def test_images_at_one_place_carry_no_scale() -> None:
    network = free_network()
    prepared, start = prepare(network), start_of(network)
    together = replace(start, position=np.zeros_like(start.position) + start.position[0])
    with pytest.raises(SingularNetworkError, match="at one place"):
        minimal_datum(prepared, layout_of(prepared), together)
