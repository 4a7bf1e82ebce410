"""Free networks: inner constraints against the dense pseudo-inverse; the same residuals and the smallest trace."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.estimation.datum import free_directions, minimal_datum
from splinebba_cli.core.estimation.gauss_markov import solve
from splinebba_cli.core.estimation.normal_equations import Assembler
from splinebba_cli.core.estimation.parameters import ParameterLayout, layout_of
from splinebba_cli.core.estimation.similarity import moved_by, similarity_directions
from splinebba_cli.core.network import Datum, DatumFeatures, Distances, FloatArray, Network
from splinebba_cli.core.observations.coefficient_rows import value_rows
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.inner_datum import STransformation, datum_columns, s_transformed
from splinebba_cli.core.quality.joint_cofactors import cofactors_of, point_cofactors
from splinebba_cli.core.quality.observation_effects import ObservationEffects
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.core.state import State, prepare
from splinebba_cli.errors import SingularNetworkError
from splinebba_cli.project.loading import load_project
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.estimation.test_minimal_datum import free_network
from tests.core.small_networks import dense_system, start_of

CHOICES = {
    "points": DatumFeatures(),
    "some points": DatumFeatures(points=("tie-1", "tie-2", "tie-7", "tie-20", "tie-25")),
    "images": DatumFeatures(points=(), images=None),
    "splines": DatumFeatures(points=(), curves=None),
    "everything": DatumFeatures(images=None, curves=None),
}
TOLERANCE = 1e-6  # of a sigma squared: the minimal datum stretches the network, its condition number is 1e5


def with_datum(features: DatumFeatures, scale: bool = False) -> Network:
    network = free_network()
    settings = replace(network.settings, datum="inner", datum_features=features)
    if scale:
        start = start_of(network)
        length = float(np.linalg.norm(start.xyz[9] - start.xyz[3]))
        bar = Distances(
            np.array([[3, 9]]), np.zeros((1, 2), dtype=bool), np.array([length]), np.array([0.01])
        )
        network = replace(network, distances=bar)
    return replace(network, settings=settings)


@cache
def solved(scale: bool) -> tuple[Network, Assembler, Cofactors]:
    """The block at the solution of a minimal datum, without any gauge condition."""
    network = with_datum(DatumFeatures(), scale)
    prepared = prepare(network)
    layout = minimal_datum(prepared, layout_of(prepared), start_of(network))
    assembler = Assembler(prepared, layout, value_rows(prepared, layout.coefficient_mask))
    found = solve(assembler, start_of(network), max_iterations=50, stage="joint", damping=1e-3)
    assert found.converged, found.termination
    return network, assembler, Cofactors(assembler, found)


def in_datum(name: str, scale: bool) -> Cofactors:
    network, assembler, minimal = solved(scale)
    settings = replace(network.settings, datum_features=CHOICES[name])
    prepared = replace(assembler.prepared, network=replace(network, settings=settings))
    effects = ObservationEffects(assembler, minimal.solution)
    return Cofactors(assembler, minimal.solution, STransformation.at(prepared, effects))


def full_width(
    orientation: FloatArray, coefficients: FloatArray, point: FloatArray, layout: ParameterLayout
) -> FloatArray:
    """Columns over all unknowns, reduced ones, then points."""
    count, first = orientation.shape[2], int(layout.node_starts[-1])
    out = np.zeros((first + layout.point_mask.size, count))
    out[: layout.image_mask.size] = orientation.reshape(-1, count)
    out[layout.unknown_of_coefficient[:, None] + np.arange(3)] = coefficients
    out[layout.unknown_of_point] = point
    return out


@cache
def dense_inner(name: str, scale: bool) -> tuple[FloatArray, ParameterLayout]:
    """S N^+ S' of all unknowns, nothing held."""
    network, assembler, minimal = solved(scale)
    settings = replace(network.settings, datum_features=CHOICES[name])
    prepared, state = (
        replace(assembler.prepared, network=replace(network, settings=settings)),
        minimal.solution.state,
    )
    layout = layout_of(prepared)
    free = Assembler(prepared, layout, value_rows(prepared, layout.coefficient_mask))
    at = free.linearize(state, held_locations(prepared, state.location))
    dense = dense_system(free, at)
    scales = np.linalg.norm(dense.design, axis=0)
    _, singular, right = np.linalg.svd(dense.design / scales, full_matrices=False)
    defect = 6 if scale else 7
    assert singular[-defect] < 1e-9 * singular[0] < 1e-3 * singular[-defect - 1]
    root = right[:-defect].T / singular[:-defect] / scales[:, None]
    whole = np.zeros((dense.width, dense.width))
    whole[np.ix_(dense.unknown, dense.unknown)] = root @ root.T
    columns = datum_columns(prepared, state)
    g = columns.directions
    return (
        s_transformed(
            whole,
            full_width(g.orientation, g.coefficients, g.point, layout),
            full_width(columns.orientation, columns.coefficients, columns.point, layout),
        ),
        layout,
    )


@pytest.mark.parametrize("scale", [False, True])
@pytest.mark.parametrize("name", CHOICES)
def test_cofactors_equal_the_dense_ones(name: str, scale: bool) -> None:
    found, (whole, layout) = in_datum(name, scale), dense_inner(name, scale)
    sigma = np.sqrt(np.diag(whole))
    curves = found.assembler.prepared.curves
    windows = (layout.unknown_of_coefficient[curves.columns][:, :, None] + np.arange(3)).reshape(
        len(curves.columns), -1
    )
    images = np.arange(layout.image_mask.size).reshape(-1, 6)
    for blocks, places in (
        (found.images, images),
        (found.coefficient_windows(curves.columns), windows),
        (found.points.own, layout.unknown_of_point),
    ):
        for block, place in zip(blocks, places, strict=True):
            difference = (block - whole[np.ix_(place, place)]) / np.outer(sigma[place], sigma[place])
            assert np.abs(difference).max() < TOLERANCE
    seen = found.assembler.prepared.network.point_observations
    for block, image, point in zip(found.points.with_image, seen.image, seen.point, strict=True):
        rows, columns = images[image], layout.unknown_of_point[point]
        difference = (block - whole[np.ix_(rows, columns)]) / np.outer(sigma[rows], sigma[columns])
        assert np.abs(difference).max() < TOLERANCE


@pytest.mark.parametrize("scale", [False, True])
def test_points_and_functions_together_equal_the_dense_ones(scale: bool) -> None:
    found, (whole, layout) = in_datum("points", scale), dense_inner("points", scale)
    sigma, points = np.sqrt(np.diag(whole)), np.array([3, 9, 20])
    place = layout.unknown_of_point[points].ravel()
    difference = point_cofactors(found, points) - whole[np.ix_(place, place)]
    assert np.abs(difference / np.outer(sigma[place], sigma[place])).max() < TOLERANCE
    functions = np.random.default_rng(6).normal(size=(4, int(layout.node_starts[-1])))
    reduced = whole[: functions.shape[1], : functions.shape[1]]
    expected = functions @ reduced @ functions.T
    own = np.sqrt(np.diag(expected))
    assert np.abs((cofactors_of(found, functions) - expected) / np.outer(own, own)).max() < TOLERANCE


@pytest.mark.parametrize("name", ["points", "images", "splines"])
def test_no_datum_has_a_smaller_trace(name: str) -> None:
    """Of the features that carry it, against every other choice and the minimal one."""

    def trace(cofactors: Cofactors) -> float:
        if name == "points":
            return float(np.einsum("nii->", cofactors.points.own))
        if name == "images":
            return float(np.einsum("mii->", cofactors.images[:, 3:, 3:]))
        curves = cofactors.assembler.prepared.curves
        total = 0.0
        for number, basis in enumerate(curves.bases):
            knots = basis.break_points[:-1] if basis.closed else basis.break_points
            segment, t = curves.locate(np.full(len(knots), number), knots)
            blocks = cofactors.coefficient_windows(curves.columns[segment]).reshape(
                len(knots), -1, 3, curves.support, 3
            )
            weights = curves.weights(segment, t)
            total += float(np.einsum("pj,pjaka,pk->", weights, blocks, weights))
        return total

    best = trace(in_datum(name, False))
    others = [trace(in_datum(other, False)) for other in CHOICES if other != name]
    assert best < min(*others, trace(solved(False)[2]))


def test_redundancy_numbers_are_the_same_in_every_datum() -> None:
    results = [adjust(with_datum(CHOICES[name])) for name in ("points", "images")]
    results.append(adjust(free_network()))
    for result in results:
        statistics = result.statistics
        assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, abs=1e-6)
    for result in results[:2]:
        assert result.statistics.sigma0 == pytest.approx(results[2].statistics.sigma0, rel=1e-8)
        for name in ("point_residuals", "curve_residuals"):
            mine, other = getattr(result, name), getattr(results[2], name)
            np.testing.assert_allclose(mine.redundancy, other.redundancy, atol=1e-6)
            np.testing.assert_allclose(mine.standardized, other.standardized, atol=2e-3)


@pytest.mark.parametrize("features", [None, DatumFeatures(points=(), images=None)])
def test_gauge_conditions_do_not_see_the_datum(features: DatumFeatures | None) -> None:
    """A close-range network whose knots slide: all conditions stay, and residuals are those of any other datum."""
    folder = Path(__file__).parents[3] / "sample_projects" / "free_network"
    network = load_project(folder / "project.yaml").network
    assert network.settings.gauge_conditions == "all"

    def adjusted(datum: Datum, chosen: DatumFeatures | None) -> AdjustmentResult:
        return adjust(
            replace(network, settings=replace(network.settings, datum=datum, datum_features=chosen))
        )

    first = adjusted("inner", DatumFeatures())
    other = adjusted("minimal" if features is None else "inner", features)
    assert other.statistics.sigma0 == pytest.approx(first.statistics.sigma0, rel=1e-7)
    for name in ("point_residuals", "curve_residuals"):
        mine, yours = getattr(first, name), getattr(other, name)
        np.testing.assert_allclose(mine.standardized, yours.standardized, atol=1e-4)
        np.testing.assert_allclose(mine.redundancy, yours.redundancy, atol=1e-5)
    trace = [np.einsum("nii->", result.points.dispersion) for result in (first, other)]
    assert trace[0] < 0.5 * trace[1]


def test_the_features_of_the_datum_fit_their_approximate_values() -> None:
    """Their mean stays, and they are neither turned nor scaled: B'(x - x0) = 0."""
    start = free_network().images.position
    result = adjust(with_datum(CHOICES["images"]))
    offset = result.images.eop[:, 3:] - start
    centred = start - start.mean(axis=0)
    size = np.abs(offset).max() * np.abs(centred).max()
    assert np.abs(offset).max() > 0.1
    assert np.abs(offset.sum(axis=0)).max() < 1e-6
    after = result.images.eop[:, 3:] - result.images.eop[:, 3:].mean(axis=0)
    assert np.abs(np.cross(after, offset).sum(axis=0)).max() < 1e-6 * size
    assert abs(np.sum(after * offset)) < 1e-6 * size


def test_adjusting_the_adjusted_values_changes_nothing() -> None:
    network = with_datum(CHOICES["images"])
    first = adjust(network)
    images = replace(
        network.images, position=first.images.eop[:, 3:] - network.origin, rotation=first.images.rotation
    )
    points = replace(network.points, xyz=first.points.xyz - network.origin)
    again = adjust(replace(network, images=images, points=points))
    moved = np.abs(again.images.eop[:, 3:] - first.images.eop[:, 3:]).max()
    assert moved < 1e-3 * np.sqrt(first.images.dispersion[:, 3:, 3:].max())


@pytest.mark.parametrize(
    "features",
    [
        DatumFeatures(points=("tie-1", "tie-2")),  # turns about the line through both
        DatumFeatures(points=(), images=("1",)),
        DatumFeatures(points=("nothing that is measured",)),
    ],
)
def test_features_that_do_not_carry_the_datum_are_refused(features: DatumFeatures) -> None:
    with pytest.raises(SingularNetworkError, match="do not carry the datum") as refused:
        adjust(with_datum(features))
    assert [problem.code for problem in refused.value.problems] == ["SBB523"]


def test_an_inner_datum_of_a_network_that_control_determines_is_that_of_the_control() -> None:
    network, _ = simulate_block("close-range-ring", 2, start_position_m=0.03, start_knots_m=0.015)
    inner, control = (
        adjust(replace(network, settings=replace(network.settings, datum="inner"))),
        adjust(network),
    )
    assert inner.statistics.vtpv == pytest.approx(control.statistics.vtpv, rel=1e-9)
    sigma = np.sqrt(np.einsum("mii->mi", control.images.dispersion))
    assert np.abs((inner.images.eop - control.images.eop) / sigma).max() < 1e-6
    np.testing.assert_allclose(inner.images.dispersion, control.images.dispersion, rtol=1e-9, atol=0.0)


def test_external_reliability_in_a_free_network_is_that_of_the_dense_one() -> None:
    """Share of the orientation in the leverage, its image held or not in the minimal datum."""
    from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
    from splinebba_cli.core.quality.redundancy import redundancy_numbers

    found, (whole, layout) = in_datum("points", False), dense_inner("points", False)
    numbers = redundancy_numbers(found, linked_cofactors(found))
    prepared, state = found.assembler.prepared, found.solution.state
    free = Assembler(prepared, layout, value_rows(prepared, layout.coefficient_mask))
    at = free.linearize(state, held_locations(prepared, state.location))
    dense = dense_system(free, at)
    rows = np.zeros((len(dense.design), dense.width))
    rows[:, dense.unknown] = dense.design
    for k in range(0, len(at.curve.image), 7):
        place = np.arange(6) + 6 * int(at.curve.image[k])
        reached = whole[place] @ rows[k]
        expected = reached @ np.linalg.solve(whole[np.ix_(place, place)], reached)
        assert numbers.curve_orientation[k] == pytest.approx(expected, abs=1e-6)


def test_similarities_move_no_image_point() -> None:
    network = free_network()
    prepared, start = prepare(network), start_of(network)
    layout = layout_of(prepared)
    free = Assembler(prepared, layout, value_rows(prepared, layout.coefficient_mask))
    directions = similarity_directions(prepared, start)

    def residuals(state: State) -> FloatArray:
        at = free.linearize(state, held_locations(prepared, state.location))
        return np.concatenate([at.curve.residual[: len(state.location)], at.points.residual.ravel()])

    before = residuals(start)
    for parameters in np.vstack([np.eye(7), np.full((1, 7), 2.0)]):
        moved = moved_by(prepared, start, directions, parameters)
        assert np.abs(moved.position - start.position).max() > 0.1
        np.testing.assert_allclose(residuals(moved), before, atol=1e-6)  # of a sigma
    dense = dense_system(free, free.linearize(start, held_locations(prepared, start.location)))
    g = full_width(directions.orientation, directions.coefficients, directions.point, layout)[dense.unknown]
    scales = np.linalg.norm(dense.design, axis=0)
    assert np.abs(dense.design @ g).max() < 1e-9 * np.abs(scales[:, None] * g).max()
    assert free_directions(prepared, layout, start).orientation.shape[2] == 7
