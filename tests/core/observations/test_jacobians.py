"""Analytic Jacobians of every kind of observation against the complex step, 1e-9 relative.

The list of kinds is compared with the modules of the package, so that a new kind cannot be forgotten.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core import observations
from splinebba_cli.core.curves.registry import FAMILIES, lasting_parameters
from splinebba_cli.core.network import Distances, FloatArray
from splinebba_cli.core.observations.coefficient_rows import CoefficientRows, gauge_rows, value_rows
from splinebba_cli.core.observations.curve_points import linearize_curve_points
from splinebba_cli.core.observations.distances import linearize_distances
from splinebba_cli.core.observations.image_points import linearize_image_points
from splinebba_cli.core.observations.orientation_priors import linearize_orientation_priors
from splinebba_cli.core.observations.shape_conditions import shape_rows
from splinebba_cli.core.state import Prepared, prepare
from tests.core.observations import complex_step
from tests.core.observations.linked_case import LINKED
from tests.core.observations.random_network import Case, random_case

NO_OBSERVATIONS = {
    "photo_polynomials",
    "foot_points",
    "corner_feet",
    "projected_places",
    "curve_point_rows",  # the same equations for assembly, compared with curve_points
    "location_search",
    "nearby_segments",
    "nearest_branch",
    "foot_points_compiled",
    "photo_segments_compiled",
    "along_curve",
    "chain_elimination",
    "curve_kinematics",
    "linked_locations",
    "linked_points",
    "locations",
    "second_order_rows",
    "structural_locations",
}  # modules that are no kind of observation
Compared = Iterator[tuple[FloatArray, FloatArray]]


@cache
def case() -> Case:
    """The configurations of all tests here."""
    return random_case()


def values_of(curve: int, coefficients: complex_step.Array) -> complex_step.Array:
    """Values of one curve from the coefficients of all, for complex coefficients."""
    curves = case().prepared.curves
    own = coefficients[curves.coefficient_start[curve] : curves.coefficient_start[curve + 1]]
    basis = curves.bases[curve]
    return np.asarray(np.einsum("kw,kwd->kd", basis.value_weights, own[basis.value_columns]))


def whole_curve_residual(k: int) -> tuple[Callable[[complex_step.Array], complex_step.Array], FloatArray]:
    """Residual (2,) of one measured curve point over (theta, X0, coefficients of its curve, u)."""
    prepared, state = case().prepared, case().state
    network, curves = prepared.network, prepared.curves
    seen = network.curve_observations
    image, curve = int(seen.image[k]), int(seen.curve[k])
    camera = network.cameras[network.images.camera[image]]
    rows = slice(int(curves.coefficient_start[curve]), int(curves.coefficient_start[curve + 1]))

    def residual(x: complex_step.Array) -> complex_step.Array:
        coefficients = state.coefficients.astype(complex)
        coefficients[rows] = x[6:-1].reshape(-1, 3)
        values, breaks = values_of(curve, coefficients), curves.bases[curve].break_points
        xyz = spline_point(curve, breaks, values, x[-1])
        rotation = complex_step.turned(state.rotation[image], x[:3])
        computed = complex_step.photo_xy(camera, rotation, x[3:6], xyz)
        return complex_step.whitened(camera, seen.sigma[k], seen.photo_xy[k], computed)

    own = state.coefficients[rows].ravel()
    x = np.concatenate([np.zeros(3), state.position[image], own, [state.location[k]]])
    return residual, x


def spline_point(
    curve: int, breaks: FloatArray, values: complex_step.Array, u: complex
) -> complex_step.Array:
    """A point of a curve; smooth pieces between corners are splines of their own."""
    one = case().prepared.network.curves[curve]
    if not one.breaks:
        return complex_step.curve_point(one, breaks, values, u)
    ends = [0, *one.breaks, len(values) - 1]
    piece = int(
        np.clip(np.searchsorted(breaks[list(one.breaks)], np.real(u), side="right"), 0, len(one.breaks))
    )
    rows = slice(ends[piece], ends[piece + 1] + 1)
    return complex_step.curve_point(replace(one, breaks=()), breaks[rows], values[rows], u)


def curve_points() -> Compared:
    """Across and along: n' and b'/|b| times the Jacobian over orientation and coefficients, n and b from the step."""
    prepared, state = case().prepared, case().state
    rows = linearize_curve_points(prepared, state, np.zeros(0, dtype=np.int64))
    curves, count = prepared.curves, len(prepared.network.curve_observations)
    assert len(rows.point) > count + 20  # most locations are no foot points: equations along the curve
    for line, k in enumerate(rows.point):
        residual, x = whole_curve_residual(int(k))
        full = complex_step.jacobian(residual, x)
        b, value = full[:, -1], np.real(residual(x))
        speed = np.linalg.norm(b)
        unit = b / speed if speed > 0.0 else np.array([0.0, 1.0])
        onto = np.array([-unit[1], unit[0]]) if line < count else unit
        analytic = np.zeros((curves.coefficient_count, 3))
        for column, weight in zip(curves.columns[rows.segment[line]], rows.weights[line], strict=True):
            analytic[column] += weight * rows.direction[line]
        start = int(curves.coefficient_start[prepared.network.curve_observations.curve[k]])
        own = analytic[start : start + (len(x) - 7) // 3]
        assert np.abs(analytic).sum() == pytest.approx(np.abs(own).sum())  # no other curve is touched
        yield rows.orientation[line], onto @ full[:, :6]
        yield own.ravel(), onto @ full[:, 6:-1]
        yield np.array([rows.residual[line]]), np.array([onto @ value])
        if line < count:
            yield np.array([rows.speed[line]]), np.array([speed])


def image_points() -> Compared:
    prepared, state = case().prepared, case().state
    network = prepared.network
    seen, rows = network.point_observations, linearize_image_points(prepared, state)
    for k in range(len(seen)):
        image = int(seen.image[k])
        camera = network.cameras[network.images.camera[image]]

        def residual(
            x: complex_step.Array, k: int = k, image: int = image, camera=camera
        ) -> complex_step.Array:
            rotation = complex_step.turned(state.rotation[image], x[:3])
            computed = complex_step.photo_xy(camera, rotation, x[3:6], x[6:])
            return complex_step.whitened(camera, seen.sigma[k], seen.photo_xy[k], computed)

        x = np.concatenate([np.zeros(3), state.position[image], state.xyz[seen.point[k]]])
        full = complex_step.jacobian(residual, x)
        yield rows.orientation[k], full[:, :6]
        yield rows.object_xyz[k], full[:, 6:]
        yield rows.residual[k], np.real(residual(x))


def orientation_priors() -> Compared:
    prepared, state = case().prepared, case().state
    images = prepared.network.images
    rows = linearize_orientation_priors(images, state)
    assert {images.sequence[i] for i in rows.image} == {"omega-phi-kappa", "phi-omega-kappa"}
    for line, image in enumerate(rows.image):
        sequence, sigma = images.sequence[image], images.prior_sigma[image]

        def residual(
            x: complex_step.Array, image: int = int(image), sequence: str = sequence
        ) -> complex_step.Array:
            turned = complex_step.turned(state.rotation[image], x[:3])
            return np.concatenate([complex_step.angles(turned, sequence), x[3:]])

        x = np.concatenate([np.zeros(3), state.position[image]])
        active = np.isfinite(sigma)
        full = complex_step.jacobian(residual, x) / sigma[:, None]
        assert np.array_equal(rows.active[line], active)
        assert (rows.jacobian[line, ~active] == 0.0).all()
        yield rows.jacobian[line, active], full[active]
        difference = np.real(residual(x)) - images.prior[image]
        difference[:3] = np.arctan(np.tan(difference[:3]))  # no quadrant, see complex_step.angles
        wrapped = rows.residual[line] * np.where(active, sigma, 0.0)
        wrapped[:3] = np.arctan(np.tan(wrapped[:3]))
        yield wrapped[active], difference[active]


def weighted(prepared: Prepared) -> Prepared:
    """Values of every curve with sigma in between, one coordinate free, and other given values."""
    generator = np.random.default_rng(8)
    curves = []
    for curve, basis in zip(prepared.network.curves, prepared.curves.bases, strict=True):
        sigma = generator.uniform(0.05, 0.5, curve.values.shape)
        sigma.flat[-1] = np.inf
        given = curve.values + generator.normal(0.0, 0.3, curve.values.shape)
        parameters = lasting_parameters(curve, basis)
        changed = replace(curve, sigma=sigma, values=given, reference=curve.values)
        curves.append(replace(changed, knot_parameters=parameters))
    return prepare(replace(prepared.network, curves=tuple(curves)))


def coefficient_rows() -> Compared:
    """Control values, and tangential conditions at the anchors with the tangent of the reference curve."""
    prepared, state = weighted(case().prepared), case().state
    curves, free = prepared.curves, np.ones((case().prepared.curves.coefficient_count, 3))
    rows = value_rows(prepared, free)
    zero = sum(
        3 * int((b.value_weights == 0.0).all(axis=1).sum()) for b in curves.bases
    )  # X'' = 0 of natural ends
    assert zero == 3
    assert len(rows) == sum(curve.values.size - 1 for curve in prepared.network.curves) - zero
    gauge = gauge_rows(prepared, free, 0.25)
    assert {int(c) for c in gauge.curve} == {k for k, b in enumerate(curves.bases) if len(b.anchors)}
    for table in (rows, gauge):
        found = table.residual(state.coefficients)
        for q in range(len(table)):
            residual, own = whole_coefficient_residual(prepared, table, q)
            x = state.coefficients[own].ravel()
            analytic = np.zeros_like(state.coefficients)
            np.add.at(analytic, table.columns[q], table.jacobian[q])
            yield analytic[own].ravel(), complex_step.jacobian(residual, x)[0]
            yield found[q : q + 1] + 1e3, np.real(residual(x)) + 1e3  # differences of coordinates of 40 m


def shape_conditions() -> Compared:
    """A circle's two conditions at coefficients that are no circle: residual and Jacobian of the quadratic forms."""
    prepared, state = weighted(case().prepared), case().state
    curves, generator = prepared.curves, np.random.default_rng(12)
    table = shape_rows(prepared, np.ones((curves.coefficient_count, 3)))
    names = [prepared.network.curves[k].id for k in table.curve]
    assert names == ["circle", "circle", "circular_arc", "circular_arc"]
    for _ in range(10):
        coefficients = state.coefficients + generator.normal(0.0, 5.0, state.coefficients.shape)
        found, jacobian = table.residual(coefficients), table.jacobian_at(coefficients)
        for q in range(len(table)):
            start = int(curves.coefficient_start[table.curve[q]])
            radius = np.sqrt(
                0.5 * np.sum(np.asarray(prepared.network.curves[table.curve[q]].reference)[1:] ** 2)
            )
            sigma = 1e-6 * radius

            def residual(x: complex_step.Array, row: int = int(table.row[q]), size: float = radius * sigma):
                _, a, b = x.reshape(3, 3)
                return np.array([(0.5 * (a @ a - b @ b) if row == 0 else a @ b) / size])

            assert table.sigma[q] == pytest.approx(sigma)
            x = coefficients[start : start + 3].ravel()
            analytic = np.zeros_like(coefficients)
            np.add.at(analytic, table.columns[q], jacobian[q])
            yield analytic[start : start + 3].ravel(), complex_step.jacobian(residual, x)[0]
            yield found[q : q + 1], np.real(residual(x))


def distances() -> Compared:
    """Between points, between images, and from one to the other."""
    state, generator = case().state, np.random.default_rng(13)
    is_image = generator.uniform(size=(40, 2)) < 0.5
    first = generator.integers(0, 12, 40)
    station = np.stack([first, first + 1 + generator.integers(0, 11, 40)], axis=1)
    given = Distances(station, is_image, generator.uniform(10.0, 500.0, 40), generator.uniform(0.01, 0.1, 40))
    rows = linearize_distances(given, state)
    for q in range(len(given)):
        ends = [
            (state.position if image else state.xyz)[k]
            for k, image in zip(station[q], is_image[q], strict=True)
        ]

        def residual(x: complex_step.Array, q: int = q) -> complex_step.Array:
            between = x[3:] - x[:3]
            return np.array([(np.sqrt(between @ between) - given.length[q]) / given.sigma[q]])

        x = np.concatenate(ends)
        yield rows.jacobian[q].ravel(), complex_step.jacobian(residual, x)[0]
        yield rows.residual[q : q + 1], np.real(residual(x))


def whole_coefficient_residual(
    prepared: Prepared, table: CoefficientRows, q: int
) -> tuple[Callable[[complex_step.Array], complex_step.Array], slice]:
    """Residual (1,) of one row over the coefficients of its curve, and their place."""
    state, number = case().state, int(table.curve[q])
    one, basis = prepared.network.curves[number], prepared.curves.bases[number]
    start = int(prepared.curves.coefficient_start[number])
    own = slice(start, start + basis.coefficient_count)
    row, component, sigma = int(table.row[q]), int(table.component[q]), table.sigma[q]

    def residual(x: complex_step.Array) -> complex_step.Array:
        coefficients = state.coefficients.astype(complex)
        coefficients[own] = x.reshape(-1, 3)
        values, breaks = values_of(number, coefficients), basis.break_points
        if component < 3:
            return np.array([(values[row, component] - one.values[row, component]) / sigma])
        u, reference = basis.anchors[row], np.asarray(one.reference)
        here = spline_point(number, breaks, values, u) - spline_point(number, breaks, reference, u)
        return np.array([tangent_at(number, breaks, reference, u) @ here / sigma])

    return residual, own


def tangent_at(number: int, breaks: FloatArray, values: FloatArray, u: float) -> FloatArray:
    """Unit tangent, at a corner the mean of both sides."""
    step = 1e-6 * np.min(np.diff(breaks))
    sides = [
        complex_step.jacobian(lambda v: spline_point(number, breaks, values, v[0]), np.array([u + d]))[:, 0]
        for d in (-step, step)
    ]
    mean = sum(side / np.linalg.norm(side) for side in sides)
    return np.asarray(mean / np.linalg.norm(mean))


KINDS: dict[str, Callable[[], Compared]] = {
    "curve_points": curve_points,
    "image_points": image_points,
    "distances": distances,
    "orientation_priors": orientation_priors,
    "coefficient_rows": coefficient_rows,
    "shape_conditions": shape_conditions,
    **LINKED,
}


def test_every_kind_of_observation_is_compared() -> None:
    modules = {module.name for module in pkgutil.iter_modules(observations.__path__)}
    assert set(KINDS) == modules - NO_OBSERVATIONS
    assert set(FAMILIES) <= {curve.family for curve in case().prepared.network.curves}


@pytest.mark.parametrize("kind", KINDS)
def test_jacobian_equals_the_complex_step(kind: str) -> None:
    count = 0
    for analytic, step in KINDS[kind]():
        size = max(float(np.abs(step).max()), 1e-9)
        np.testing.assert_allclose(analytic, step, rtol=0.0, atol=1e-9 * size)
        count += 1
    assert count >= 40  # two blocks or more of each of 20 configurations
