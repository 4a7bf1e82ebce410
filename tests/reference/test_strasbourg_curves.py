"""Strasbourg: 381 points and 30 traced curves in one adjustment, from deliberately wrong approximate values.

Images and points: Boerlin & Grussenmeyer, DBAT 0.9.2; curves traced in the same five images (reference/README.md).
Exterior orientations start 5 m and 0.2 degrees off, curve knots 2 m (sigma per coordinate), all at once.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.camera.rotation import rotation_from_vector
from splinebba_cli.core.network import FloatArray, KnotPolicy, Network
from splinebba_cli.core.result import AdjustmentResult
from tests.reference_data import (
    reference_dir,
    strasbourg_curves_network,
    strasbourg_points_network,
    with_orientation,
)

pytestmark = pytest.mark.skipif(
    not (reference_dir() / "strasbourg_aerial").is_dir(), reason="reference data are not there"
)
PIXEL_MM = 0.006
KNOTS_EVERY_M = 3.0


def eop_sigma(result: AdjustmentResult) -> FloatArray:
    return np.sqrt(np.einsum("mii->mi", result.images.dispersion))


def wrong_start(seed: int) -> Network:
    network = strasbourg_curves_network(approximate=True)
    generator = np.random.default_rng(seed)
    curves = tuple(
        replace(
            curve, values=curve.values + generator.normal(0.0, 2.0, curve.values.shape), knot_parameters=None
        )
        for curve in network.curves
    )
    shift, turn = generator.normal(size=(2, 5, 3))
    shift *= 5.0 / np.linalg.norm(shift, axis=1)[:, None]
    turn *= np.radians(0.2) / np.linalg.norm(turn, axis=1)[:, None]
    images = network.images
    network = with_orientation(network, images.rotation @ rotation_from_vector(turn), images.position + shift)
    settings = replace(network.settings, knots=KnotPolicy(spacing_m=KNOTS_EVERY_M, drop=True))
    return replace(network, curves=curves, settings=settings)


@pytest.fixture(scope="module")
def points_only() -> AdjustmentResult:
    return adjust(strasbourg_points_network(approximate=False))


@pytest.fixture(scope="module")
def joint() -> AdjustmentResult:
    return adjust(wrong_start(seed=1))


def test_residuals_across_the_curves_are_those_of_good_edges(joint: AdjustmentResult) -> None:
    rms_px = np.sqrt(np.mean(joint.curve_residuals.across**2)) / PIXEL_MM
    assert rms_px <= 0.60


def test_variance_of_unit_weight_is_near_one(joint: AdjustmentResult) -> None:
    assert 0.90 < joint.statistics.sigma0 < 1.10


def test_orientations_agree_with_the_points_only_solution(
    joint: AdjustmentResult, points_only: AdjustmentResult
) -> None:
    difference = np.abs(joint.images.eop - points_only.images.eop) / eop_sigma(points_only)
    assert difference.max() < 3.0


def test_curves_pay(joint: AdjustmentResult, points_only: AdjustmentResult) -> None:
    assert (eop_sigma(joint) / eop_sigma(points_only)).max() <= 0.85


def test_redundancy_numbers_sum_to_the_redundancy(joint: AdjustmentResult) -> None:
    statistics = joint.statistics
    assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, rel=1e-9)
    assert statistics.redundancy == statistics.observations + statistics.conditions - statistics.unknowns


def test_kerbs_lie_at_the_height_of_the_ground_control(joint: AdjustmentResult) -> None:
    """Ground-level curves (Z below 142 m) near a control point lie at its height.

    Within three sigma of the curve and 0.5 m for the street, whose control points scatter by that much.
    """
    control = [k for k, role in enumerate(joint.network.points.role) if role == "control"]
    ground = joint.points.xyz[control]
    compared = 0
    for curve in joint.curves:
        height = float(np.median(curve.sample_xyz[:, 2]))
        distance = np.linalg.norm(ground[:, :2] - curve.sample_xyz[:, :2].mean(axis=0), axis=1)
        if height > 142.0 or distance.min() > 100.0:
            continue
        sigma = np.hypot(np.median(curve.knot_sigma[:, 2]), 0.5)
        assert abs(height - ground[np.argmin(distance), 2]) < 3.0 * sigma
        compared += 1
    assert compared >= 2
