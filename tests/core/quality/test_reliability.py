"""Reliability of all kinds of observations against the dense inverse; effects of errors against the dense solution."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import linked_cofactors
from splinebba_cli.core.quality.observation_effects import EquationColumns, ObservationEffects
from splinebba_cli.core.quality.redundancy import RedundancyNumbers, redundancy_numbers
from splinebba_cli.core.quality.reliability import reliability
from splinebba_cli.core.result import AdjustmentResult
from tests.core.small_networks import DenseSystem, dense_system, mixed_network, solved

TOLERANCE = 1e-8  # of the sigma of an unknown; see test_cofactors.py for the digits that are left


@cache
def systems() -> tuple[Cofactors, DenseSystem, FloatArray, RedundancyNumbers]:
    found = solved(mixed_network()[0])
    dense = dense_system(found.assembler, found.solution.linearization)
    cofactors = Cofactors(found.assembler, found.solution)
    return cofactors, dense, dense.inverse, redundancy_numbers(cofactors, linked_cofactors(cofactors))


@cache
def result() -> AdjustmentResult:
    return adjust(mixed_network()[0])


def full_rows() -> FloatArray:
    """All whitened equations over all unknowns, removed ones zero."""
    _, dense, _, _ = systems()
    rows = np.zeros((len(dense.design), dense.width))
    rows[:, dense.unknown] = dense.design
    return rows


def share(row: FloatArray, image: int) -> float:
    """a Q_.i Q_ii^-1 Q_i. a' by the dense inverse."""
    inverse = systems()[2]
    place = slice(6 * image, 6 * image + 6)
    reached = inverse[place] @ row
    return float(reached @ np.linalg.pinv(inverse[place, place], rcond=1e-10) @ reached)


def test_part_of_the_orientation_in_the_leverage_of_curve_points() -> None:
    cofactors, _, _, numbers = systems()
    curve = cofactors.solution.linearization.curve
    rows = full_rows()
    expected = [share(rows[k], int(curve.image[k])) for k in range(len(curve.image))]
    np.testing.assert_allclose(numbers.curve_orientation, expected, rtol=0, atol=TOLERANCE)
    assert (numbers.curve_orientation <= 1.0 - numbers.curve_rows + TOLERANCE).all()


def test_part_of_the_orientation_in_the_leverage_of_image_points() -> None:
    cofactors, _, _, numbers = systems()
    observed = cofactors.assembler.prepared.network.point_observations
    first = len(cofactors.solution.linearization.curve.image)
    rows = full_rows()[first : first + 2 * len(observed)]
    expected = [share(row, int(observed.image[k // 2])) for k, row in enumerate(rows)]
    np.testing.assert_allclose(numbers.point_orientation.ravel(), expected, rtol=0, atol=TOLERANCE)


def columns_of(kind: str) -> tuple[EquationColumns, FloatArray]:
    """Columns of some equations of a kind, and the same rows of the dense design."""
    cofactors, _, _, _ = systems()
    effects, at = (
        ObservationEffects(cofactors.assembler, cofactors.solution),
        cofactors.solution.linearization,
    )
    rows, n_curve = full_rows(), len(at.curve.image)
    n_points, n_priors = at.points.residual.size, int(at.orientation_priors.active.sum())
    q, c = np.nonzero(at.orientation_priors.active)
    n, d = np.nonzero(cofactors.assembler.point_inverse_sigma > 0.0)
    n_distances = len(at.distances.residual)
    begin = {"spline": 0, "point": n_curve, "distance": n_curve + n_points}
    begin["prior"] = begin["distance"] + n_distances
    begin["control point"] = begin["prior"] + n_priors
    begin["control spline"] = begin["control point"] + len(n)
    first = rows[begin[kind] :]
    chosen = np.array([0, 1, 5])
    if kind == "spline":
        chosen = np.array([0, 7, n_curve - 1])  # the last one along the curve, at a held location
        return effects.curve_rows(chosen), first[chosen]
    if kind == "point":
        return effects.image_points(chosen // 2, chosen % 2), first[chosen]
    if kind == "distance":
        return effects.distances(chosen), first[chosen]
    if kind == "prior":
        return effects.orientation_priors(q[chosen], c[chosen]), first[chosen]
    if kind == "control point":
        return effects.point_priors(n[chosen], d[chosen]), first[chosen]
    return effects.coefficient_rows(chosen), first[chosen]


@pytest.mark.parametrize("kind", ["spline", "point", "distance", "prior", "control point", "control spline"])
def test_effects_of_errors_equal_the_dense_solution(kind: str) -> None:
    cofactors, _, inverse, _ = systems()
    columns, rows = columns_of(kind)
    errors = np.array([1.0, -2.0, 3.0])
    found = ObservationEffects(cofactors.assembler, cofactors.solution).of(columns, errors)
    expected = inverse @ rows.T * errors
    sigma = np.sqrt(np.diag(inverse))
    sigma[sigma == 0.0] = 1.0
    layout = cofactors.assembler.layout
    for values, place in (
        (found.orientation.reshape(-1, 3), np.arange(layout.image_mask.size)),
        (found.coefficients.reshape(-1, 3), (layout.unknown_of_coefficient[:, None] + np.arange(3)).ravel()),
        (found.point.reshape(-1, 3), layout.unknown_of_point.ravel()),
    ):
        difference = (values - expected[place]) / sigma[place][:, None]
        assert np.abs(difference).max() < TOLERANCE * 3.0


def test_formulas() -> None:
    found = reliability(
        np.array([5.0, 5.0, 5.0]), np.array([0.25, 0.0, np.nan]), np.array([0.5, 1.0, 0.0]), 4.0
    )
    np.testing.assert_allclose(found.minimal_detectable_bias, [40.0, np.inf, np.nan])
    np.testing.assert_allclose(found.bias_to_noise, [4.0 * np.sqrt(3.0), np.inf, np.nan])
    np.testing.assert_allclose(found.orientation_influence, [4.0 * np.sqrt(2.0), np.inf, np.nan])


def test_observations_without_control_have_no_test() -> None:
    """Curve points are tested across only, unless their location is held."""
    table = result().curve_residuals
    free = np.isnan(table.standardized[:, 1])
    assert free.sum() == len(free) - 3
    assert np.isnan(table.reliability.minimal_detectable_bias[free, 1]).all()
    assert np.isfinite(table.reliability.minimal_detectable_bias[~free]).all()


def test_all_observations_are_counted_once() -> None:
    found, tests = result(), result().evidence.tests
    assert tests is not None
    priors = [p for p in found.prior_residuals if np.isfinite(p.standardized)]
    coordinates = found.point_residuals.residual.size + len(found.curve_residuals.across)
    assert tests.tests == coordinates + 3 + len(found.network.distances) + len(priors)
    assert not any(np.isfinite(p.standardized) for p in found.prior_residuals if p.kind == "gauge")


def test_most_influential_observations_by_a_changed_measurement() -> None:
    """An error of one MDB put into an image coordinate moves the adjusted values as was said."""
    found = result()
    worst = next(i for i in found.evidence.influences if i.kind == "point")
    network = found.network
    image, point = worst.name.split("`")[1], worst.name.split("`")[3]
    axis = "xy".index(worst.name[-1])
    seen = network.point_observations
    row = next(
        k for k in range(len(seen))
        if network.images.ids[seen.image[k]] == image and network.points.ids[seen.point[k]] == point
    )  # fmt: skip
    share_of_mdb = 0.01  # small: the effect is linear
    xy = mixed_network()[0].point_observations.photo_xy.copy()
    xy[row, axis] += share_of_mdb * worst.minimal_detectable_bias
    start = mixed_network()[0]
    moved = adjust(replace(start, point_observations=replace(start.point_observations, photo_xy=xy)))
    step = np.linalg.norm(moved.images.eop[:, 3:] - found.images.eop[:, 3:], axis=1) / share_of_mdb
    assert network.images.ids[int(np.argmax(step))] == worst.position_image
    assert step.max() == pytest.approx(worst.position_m, rel=0.02)
