"""Ways of writing the same project differently (theory, section 10.4).

Another object frame, another order of images, points and curves, the other rotation sequence, other units: the same
residuals, the same variance of unit weight, the transformed dispersion.  Iterations end when a step is negligible
against sigma: estimates are compared to a thousandth of sigma, dispersions (which follow them) likewise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.camera.rotation import angles_from_rotation
from splinebba_cli.core.network import FloatArray, RotationSequence
from splinebba_cli.core.result import AdjustmentResult
from tests.properties.transformed_networks import (
    Similarity,
    moved,
    observation_order,
    original,
    other_photo_unit,
    permuted,
    rotation_dispersion,
    small_network,
)

SMALL = 1e-3  # of sigma
few = settings(max_examples=4, deadline=None, derandomize=True, phases=[Phase.generate])
angle = st.floats(-np.pi, np.pi)
SAME = Similarity(1.0, np.eye(3), np.zeros(3))


def off(found: FloatArray, expected: FloatArray, dispersion: FloatArray) -> float:
    """Largest difference of positions (n, 3) in sigma of their dispersions (n, 3, 3)."""
    sigma = np.sqrt(np.einsum("nii->ni", dispersion)).max(axis=1, keepdims=True)
    return float(np.max(np.abs(found - expected) / np.where(sigma > 0.0, sigma, 1.0)))


def off_dispersion(found: FloatArray, expected: FloatArray) -> float:
    """Largest difference of dispersions (n, p, p) relative to the variances."""
    sigma = np.sqrt(np.maximum(np.einsum("nii->ni", expected), 1e-300))
    scale = sigma[:, :, None] * sigma[:, None, :]
    return float(np.max(np.abs(found - expected) / np.maximum(scale, 1e-30)))


def same_fit(found: AdjustmentResult, photo_unit: float = 1.0) -> None:
    """Counts, variance of unit weight and residuals in the order of the original."""
    mine, first = found.statistics, original().statistics
    for name in ("observations", "unknowns", "conditions", "rank_defect", "redundancy"):
        assert getattr(mine, name) == getattr(first, name), name
    assert abs(mine.sigma0 / first.sigma0 - 1.0) < 1e-6
    assert abs(mine.sum_redundancy_numbers - first.sum_redundancy_numbers) < 1e-5
    tables = (
        (found.point_residuals, original().point_residuals, small_network().point_observations.sigma),
        (found.curve_residuals, original().curve_residuals, small_network().curve_observations.sigma),
    )
    for table, expected, sigma in tables:
        assert np.abs((table.residual / photo_unit - expected.residual) / sigma).max() < SMALL
        assert np.abs(table.redundancy - expected.redundancy).max() < SMALL


def same_geometry(found: AdjustmentResult, to: Similarity) -> None:
    """Orientations, points and curves of the original in the other frame, with their dispersion."""
    first = original()
    blocks, expected = rotation_dispersion(found), rotation_dispersion(first)
    expected[:, 3:, 3:] = to.dispersion(expected[:, 3:, 3:])
    expected[:, :3, 3:] = to.scale * expected[:, :3, 3:] @ to.rotation.T
    expected[:, 3:, :3] = np.swapaxes(expected[:, :3, 3:], 1, 2)
    positions = to.positions(first.images.eop[:, 3:])
    assert off(found.images.eop[:, 3:], positions, expected[:, 3:, 3:]) < SMALL
    turned = np.swapaxes(to.rotation @ first.images.rotation, 1, 2) @ found.images.rotation
    theta = Rotation.from_matrix(turned).as_rotvec()
    assert off(theta, np.zeros_like(theta), expected[:, :3, :3]) < SMALL
    assert off_dispersion(blocks, expected) < SMALL
    spread = to.dispersion(first.points.dispersion)
    assert off(found.points.xyz, to.positions(first.points.xyz), spread) < SMALL
    assert off_dispersion(found.points.dispersion, spread) < SMALL
    for mine, yours in zip(found.curves, first.curves, strict=True):
        spread = to.dispersion(yours.values_dispersion)
        assert off(mine.values, to.positions(yours.values), spread) < SMALL
        free = np.einsum("nii->n", spread) > 0.0
        assert off_dispersion(mine.values_dispersion[free], spread[free]) < 10 * SMALL
        np.testing.assert_allclose(
            mine.sample_across, to.scale * yours.sample_across, rtol=5e-3, atol=1e-9 * to.scale
        )
    for check, other in zip(found.checks.points, first.checks.points, strict=True):
        np.testing.assert_allclose(check.normalized, other.normalized, rtol=0.0, atol=SMALL)


@few
@given(
    omega=angle, phi=angle, kappa=angle, logarithm=st.floats(-2.0, 2.0),
    x=st.floats(-1e4, 1e4), y=st.floats(-1e4, 1e4), z=st.floats(-1e3, 1e3),
)  # fmt: skip
def test_another_object_frame(
    omega: float, phi: float, kappa: float, logarithm: float, x: float, y: float, z: float
) -> None:
    """Shifted, turned any way and in another unit of length: kilometres to centimetres."""
    rotation = Rotation.from_euler("xyz", [omega, phi, kappa]).as_matrix()
    to = Similarity(10.0**logarithm, rotation, np.array([x, y, z]))
    network = moved(small_network(), to)
    assume(np.abs(np.cos(angles_from_rotation(network.images.rotation)[:, 1])).min() > 0.05)
    found = adjust(network)
    same_fit(found)
    same_geometry(found, to)


@few
@given(seed=st.integers(0, 10**6))
def test_another_order(seed: int) -> None:
    """Images, points, curves and all observations shuffled."""
    network = small_network()
    generator = np.random.default_rng(seed)
    images, points, curves = (
        generator.permutation(len(x)) for x in (network.images.ids, network.points.ids, network.curves)
    )
    found = adjust(permuted(network, images, points, curves, seed))
    back_image, back_point, back_curve = np.argsort(images), np.argsort(points), np.argsort(curves)
    back_ray, back_seen = (np.argsort(order) for order in observation_order(network, seed))
    restored = replace(
        found,
        network=replace(
            found.network,
            images=replace(
                found.network.images, sequence=tuple(found.network.images.sequence[i] for i in back_image)
            ),
        ),
        images=replace(
            found.images, eop=found.images.eop[back_image], rotation=found.images.rotation[back_image],
            dispersion=found.images.dispersion[back_image],
        ),
        points=replace(
            found.points, xyz=found.points.xyz[back_point], dispersion=found.points.dispersion[back_point]
        ),
        curves=tuple(found.curves[i] for i in back_curve),
        point_residuals=replace(
            found.point_residuals, residual=found.point_residuals.residual[back_ray],
            redundancy=found.point_residuals.redundancy[back_ray],
        ),
        curve_residuals=replace(
            found.curve_residuals, residual=found.curve_residuals.residual[back_seen],
            redundancy=found.curve_residuals.redundancy[back_seen],
        ),
        checks=replace(
            found.checks,
            points=tuple(sorted(found.checks.points, key=lambda check: network.points.ids.index(check.id))),
        ),
    )  # fmt: skip
    same_fit(restored)
    same_geometry(restored, SAME)


@few
@given(swapped=st.lists(st.booleans(), min_size=6, max_size=6))
def test_the_other_rotation_sequence(swapped: list[bool]) -> None:
    """In some images or all: the same rotations; angles and their dispersion of the declared sequence."""
    names: tuple[RotationSequence, RotationSequence] = ("omega-phi-kappa", "phi-omega-kappa")
    network = small_network()
    sequence = tuple(names[swap] for swap in swapped)
    found = adjust(replace(network, images=replace(network.images, sequence=sequence)))
    same_fit(found)
    same_geometry(found, SAME)
    for i, name in enumerate(sequence):
        expected = angles_from_rotation(found.images.rotation[i], name)
        np.testing.assert_allclose(found.images.eop[i, :3], expected, rtol=0.0, atol=1e-12)


@few
@given(logarithm=st.floats(-3.0, 3.0))
def test_another_unit_of_photo_coordinates(logarithm: float) -> None:
    """Micrometres or metres instead of millimetres."""
    factor = 10.0**logarithm
    found = adjust(other_photo_unit(small_network(), factor))
    same_fit(found, factor)
    same_geometry(found, SAME)


@few
@given(logarithm=st.floats(-0.3, 0.3))
def test_another_unit_of_weight(logarithm: float) -> None:
    """All sigma times a factor: the estimates and their dispersion stay, sigma0 is divided by it."""
    factor = 10.0**logarithm
    network = small_network()
    rays, seen = network.point_observations, network.curve_observations
    known = [replace(curve, sigma=curve.sigma * factor) for curve in network.curves]
    points = replace(network.points, sigma=network.points.sigma * factor)
    images = replace(network.images, prior_sigma=network.images.prior_sigma * factor)
    found = adjust(
        replace(
            network, images=images, points=points, curves=tuple(known),
            point_observations=replace(rays, sigma=factor * rays.sigma),
            curve_observations=replace(seen, sigma=factor * seen.sigma),
        )
    )  # fmt: skip
    assert found.statistics.conditions == original().statistics.conditions
    assert abs(found.statistics.sigma0 * factor / original().statistics.sigma0 - 1.0) < 1e-5
    same_geometry(found, SAME)
    difference = found.curve_residuals.residual - original().curve_residuals.residual
    assert np.abs(difference / seen.sigma).max() < SMALL


@few
@given(east=st.floats(-1e7, 1e7), north=st.floats(-1e7, 1e7))
def test_coordinates_of_any_size(east: float, north: float) -> None:
    """The origin of the local frame carries them: results shift, and nothing else changes at all."""
    shift = np.round([east, north, 0.0], -3)
    found = adjust(replace(small_network(), origin=small_network().origin + shift))
    assert found.statistics.vtpv == original().statistics.vtpv
    np.testing.assert_array_equal(found.images.dispersion, original().images.dispersion)
    np.testing.assert_allclose(found.points.xyz - shift, original().points.xyz, rtol=0.0, atol=1e-8)
    for mine, yours in zip(found.curves, original().curves, strict=True):
        np.testing.assert_allclose(mine.values - shift, yours.values, rtol=0.0, atol=1e-8)
