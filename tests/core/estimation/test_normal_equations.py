"""The assembled and reduced normal equations of a small mixed network against the dense design matrix."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.estimation.block_matrix import BlockMatrix
from splinebba_cli.core.estimation.gauss_markov import apply_step
from splinebba_cli.core.estimation.normal_equations import Assembler, Linearization
from splinebba_cli.core.estimation.parameters import layout_of
from splinebba_cli.core.network import Distances, FloatArray
from splinebba_cli.core.observations import second_order_rows as second_order
from splinebba_cli.core.observations.coefficient_rows import concatenate_rows, gauge_rows, value_rows
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import prepare
from tests.core.small_networks import DenseSystem, dense_system, mixed_network, start_of

TOLERANCE = 1e-10  # of the root of the product of the diagonal elements


@cache
def equations() -> tuple[Assembler, Linearization, DenseSystem]:
    """All equations at the approximate values, residuals of many sigma."""
    network = mixed_network()[0]
    prepared, state = prepare(network), start_of(network)
    layout = layout_of(prepared)
    state = replace(state, xyz=state.xyz + 0.05 * layout.point_mask)
    rows = [
        value_rows(prepared, layout.coefficient_mask),
        gauge_rows(prepared, layout.coefficient_mask, None),
    ]
    assembler = Assembler(prepared, layout, concatenate_rows(rows, prepared.curves.support))
    at = assembler.linearize(state, held_locations(prepared, state.location))
    return assembler, at, dense_system(assembler, at)


def dense_normal(damping: float) -> tuple[FloatArray, FloatArray]:
    """A'A with its diagonal times 1 + damping, and -A'r, in full width; unit diagonal for removed unknowns."""
    _, _, dense = equations()
    normal, side = np.eye(dense.width), np.zeros(dense.width)
    product = dense.design.T @ dense.design
    normal[np.ix_(dense.unknown, dense.unknown)] = product + damping * np.diag(np.diag(product))
    side[dense.unknown] = -dense.design.T @ dense.residual
    return normal, side


def without_points(damping: float) -> tuple[FloatArray, FloatArray, int]:
    """The dense system with the points eliminated by their Schur complement; number of reduced unknowns."""
    assembler, _, _ = equations()
    normal, side = dense_normal(damping)
    n = int(assembler.layout.node_starts[-1])
    gain = np.linalg.solve(normal[n:, n:], normal[n:, :n]).T
    return normal[:n, :n] - gain @ normal[n:, :n], side[:n] - gain @ side[n:], n


def relative(found: FloatArray, dense: FloatArray) -> float:
    root = np.sqrt(np.diag(dense))
    return float(np.abs((found - dense) / np.outer(root, root)).max())


def test_the_network_holds_every_kind_of_equation() -> None:
    assembler, at, dense = equations()
    component = assembler.coefficient_rows.component
    assert (component == 3).any() and (component < 3).any()
    assert at.orientation_priors.active.sum() == 11 and (at.point_prior_residual != 0.0).any()
    assert len(at.curve.point) > len(at.curve.speed)  # held locations
    assert (assembler.layout.coefficient_mask == 0.0).sum() > 0 and (assembler.layout.point_mask == 0.0).any()
    assert (assembler.layout.image_mask == 0.0).sum() == 7
    assert len(dense.unknown) < dense.width


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_reduced_matrix_and_right_hand_side(damping: float) -> None:
    assembler, at, _ = equations()
    matrix, vector, _ = without_points(damping)
    values, side, _ = assembler.eliminate(at, damping)
    found = BlockMatrix(assembler.structure, values).to_dense()
    removed = np.flatnonzero(assembler.mask == 0.0)
    assert np.count_nonzero(found[removed]) == len(removed)  # alone on their rows, whatever stands there
    matrix[removed, removed] = found[removed, removed]
    assert relative(found, matrix) < TOLERANCE
    scale = np.sqrt(np.diag(matrix)) * np.linalg.norm(equations()[2].residual)
    assert np.abs((side - vector) / scale)[assembler.mask > 0.0].max() < TOLERANCE


def test_before_the_elimination_of_points() -> None:
    assembler, at, _ = equations()
    normal, _ = dense_normal(0.0)
    n = int(assembler.layout.node_starts[-1])
    found = BlockMatrix(assembler.structure, at.base_values).to_dense()
    assert relative(found, normal[:n, :n]) < TOLERANCE


def test_the_cost_is_the_sum_of_squares() -> None:
    _, at, dense = equations()
    # photo coordinates of 100 mm and sigma of microns: rounding of 1e-12 sigma in every residual
    assert at.cost == pytest.approx(dense.residual @ dense.residual, rel=1e-12)


def test_a_step_solves_the_whole_system() -> None:
    """Reduced solution and back-substituted points equal the dense solution of all unknowns together."""
    assembler, at, _ = equations()
    from splinebba_cli.core.estimation.gauss_markov import _point_step

    normal, side = dense_normal(0.0)
    root = np.sqrt(np.diag(normal))
    whole = np.linalg.solve(normal / np.outer(root, root), side / root) / root
    values, reduced_side, eliminated = assembler.eliminate(at, 0.0)
    reduced = assembler.symbolic(at.state).factorize(values).solve(reduced_side) * assembler.mask
    points = _point_step(assembler, eliminated, reduced)
    kept = assembler.layout.kept_points
    np.testing.assert_array_equal(points[kept], reduced[assembler.layout.unknown_of_point[kept]])
    points_behind = np.where((assembler.layout.node_of_point < 0)[:, None], points, 0.0)
    found = np.concatenate([reduced, points_behind.ravel()])
    sigma = np.sqrt(np.diag(equations()[2].inverse))
    free = sigma > 0.0
    assert np.abs((found - whole)[free] / sigma[free]).max() < 1e-9 * np.linalg.norm(equations()[2].residual)
    assert (found[~free] == 0.0).all()
    moved = apply_step(assembler, at.state, reduced, points)
    np.testing.assert_array_equal(moved.position[2], at.state.position[2])  # fixed
    np.testing.assert_array_equal(moved.rotation[2], at.state.rotation[2])
    assert moved.position[3, 2] == at.state.position[3, 2]


def test_stiffness_adds_its_share_of_the_equations_along(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every share counts here: with bend k the factor k / (1 + k) of the equation along the curve."""
    monkeypatch.setattr(second_order, "SHARE", 0.0)
    assembler, at, _ = equations()
    at = assembler.linearize(at.state, held_locations(assembler.prepared, at.state.location))
    stiff = second_order.second_order_rows(assembler.prepared, at.state)
    assert len(stiff.point) > 20
    rows = np.zeros((len(stiff.point), int(assembler.layout.node_starts[-1])))
    columns = assembler.layout.unknown_of_coefficient[assembler.prepared.curves.columns[stiff.segment]]
    for k, image in enumerate(stiff.image):
        rows[k, 6 * image : 6 * image + 6] = stiff.orientation[k]
        for slot, column in enumerate(columns[k]):
            rows[k, column : column + 3] += stiff.weights[k, slot] * stiff.direction[k]
    rows *= assembler.mask
    found = BlockMatrix(assembler.structure, assembler.stiffness(at)).to_dense()
    expected = rows.T @ rows
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_a_network_without_points_or_without_curves() -> None:
    """The same equations where one of both is missing."""
    network = replace(mixed_network()[0], distances=Distances.none())
    none = network.point_observations
    empty = replace(
        none, image=none.image[:0], point=none.point[:0], photo_xy=none.photo_xy[:0], sigma=none.sigma[:0]
    )
    points = replace(
        network.points,
        ids=(),
        role=(),
        xyz=np.zeros((0, 3)),
        sigma=np.zeros((0, 3)),
        check_sigma=np.zeros((0, 3)),
    )
    seen = network.curve_observations
    no_curve = replace(
        seen, image=seen.image[:0], curve=seen.curve[:0], photo_xy=seen.photo_xy[:0], sigma=seen.sigma[:0],
        location=seen.location[:0], segment=seen.segment[:0],
    )  # fmt: skip
    for case in (
        replace(network, points=points, point_observations=empty),
        replace(network, curves=(), curve_observations=no_curve),
    ):
        prepared, state = prepare(case), start_of(case)
        layout = layout_of(prepared)
        rows = value_rows(prepared, layout.coefficient_mask)
        assembler = Assembler(prepared, layout, rows)
        at = assembler.linearize(state, held_locations(prepared, state.location))
        dense = dense_system(assembler, at)
        product = np.eye(dense.width)
        product[np.ix_(dense.unknown, dense.unknown)] = dense.design.T @ dense.design
        n = int(layout.node_starts[-1])
        gain = np.linalg.solve(product[n:, n:], product[n:, :n])
        schur = product[:n, :n] - product[:n, n:] @ gain
        found = BlockMatrix(assembler.structure, assembler.eliminate(at, 0.0)[0]).to_dense()
        assert relative(found, schur) < TOLERANCE
