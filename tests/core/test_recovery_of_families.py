"""Noise-free measurements give every family back from perturbed starts; all of them in one network too.

Starts are off by up to 0.3 m in every coordinate of every row.  Curves are compared across (1e-9 of the size of the
block); where every direction is determined or held by pure gauge conditions, values as well.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.feature_geometry import Feature
from splinebba_cli.simulation.truth import Truth
from tests.core.family_features import ALL, circle_rows, joined, of_family, with_options
from tests.core.free_curves import WINDING, block_with, tie

SIZE = 1000.0  # m
TOLERANCE = 1e-9 * SIZE


def distance_from_truth(feature: Feature, found: FloatArray) -> float:
    """Largest distance of points from the true curve, m."""
    basis, coefficients = feature.shape()
    return float(nearest_on_curve(basis, coefficients, found)[1].max())


def test_every_family_is_there() -> None:
    assert {feature.family for feature in ALL} == set(FAMILIES)


@pytest.mark.parametrize("feature", ALL, ids=lambda feature: feature.id)
def test_the_truth_comes_back(feature: Feature) -> None:
    network, truth = block_with(feature, fixed=True, noise_um=0.0, per_curve=20)
    assert np.abs(network.curves[0].values - truth.curves[0]).max() > 0.05
    result = adjust(network)
    statistics = result.statistics
    assert statistics.vtpv < 1e-9
    assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, abs=1e-4)
    assert distance_from_truth(feature, result.curves[0].sample_xyz) < TOLERANCE
    assert np.abs(result.curves[0].values - truth.curves[0]).max() < TOLERANCE


@cache
def together(noise_um: float) -> tuple[Network, Truth, AdjustmentResult]:
    """All families and options in one network, orientations free, from points and curves."""
    network, truth = block_with(*ALL, noise_um=noise_um, per_curve=14)
    return network, truth, adjust(network)


def test_all_families_in_one_network_without_noise() -> None:
    _, truth, result = together(0.0)
    assert result.statistics.vtpv < 1e-6
    assert np.abs(result.images.eop[:, 3:] - truth.eop[:, 3:]).max() < TOLERANCE
    for feature, found in zip(ALL, result.curves, strict=True):
        assert distance_from_truth(feature, found.sample_xyz) < 10.0 * TOLERANCE, feature.id


def test_all_families_in_one_network_with_noise() -> None:
    """A variance of unit weight near 1 (redundancy r, 1e-5 of chi-square), redundancy numbers that sum to r."""
    _, _, result = together(5.0)
    statistics = result.statistics
    assert statistics.sum_redundancy_numbers == pytest.approx(statistics.redundancy, abs=1e-3)
    assert abs(statistics.sigma0**2 - 1.0) < 4.4 * np.sqrt(2.0 / statistics.redundancy)
    shapes = sum(2 for feature in ALL if feature.family == "circle")
    kinds = [prior.kind for prior in result.prior_residuals]
    assert kinds.count("shape") == shapes
    assert statistics.conditions == kinds.count("gauge") + shapes


def test_circles_stay_circles() -> None:
    """|A| = |B| and A . B = 0 to rounding at every solution."""
    _, _, result = together(5.0)
    for feature, found in zip(ALL, result.curves, strict=True):
        if feature.family == "circle":
            _, a, b = found.values
            assert abs(np.linalg.norm(a) - np.linalg.norm(b)) < 1e-10
            assert abs(a @ b) < 1e-9 * (a @ a)
            radius = np.linalg.norm(found.sample_xyz - found.values[0], axis=1)
            np.testing.assert_allclose(radius, np.linalg.norm(a), rtol=1e-11)


@pytest.mark.parametrize("noise_um", [0.0, 5.0])
def test_a_wrong_shape_at_the_start_becomes_a_circle(noise_um: float) -> None:
    """Radius vectors 20 % too long and 10 degrees off: the first state is the nearest circle."""
    network, truth = block_with(of_family("circle"), fixed=True, noise_um=noise_um, per_curve=20)
    values = truth.curves[0].copy()
    values[1], values[2] = 1.2 * values[1], values[2] + 0.17 * values[1]
    result = adjust(replace(network, curves=(replace(network.curves[0], values=values, reference=None),)))
    radius = 0.5 * (np.linalg.norm(result.curves[0].values[1]) + np.linalg.norm(result.curves[0].values[2]))
    assert abs(radius - 60.0) < (TOLERANCE if noise_um == 0.0 else 0.02)


@pytest.mark.parametrize("continuity", [-1, 0, 1, 2])
def test_the_start_point_of_joined_segments_is_held_exactly(continuity: int) -> None:
    """Lee's partial control spline: row 0 is held; the other rows start with values that are not continuous."""
    whole = joined(3, continuity)
    sigma = np.full(whole.values.shape, np.inf)
    sigma[0] = 0.0
    feature = with_options(whole, role="partial", sigma=sigma)
    network, truth = block_with(feature, fixed=True, noise_um=5.0, per_curve=20)
    result = adjust(network)
    assert np.abs(result.curves[0].values[0] - truth.curves[0][0]).max() < 1e-9
    assert np.abs(result.curves[0].values_dispersion[0]).max() == 0.0
    assert np.abs(result.curves[0].values_dispersion[1]).max() > 0.0


def test_an_inner_row_of_joined_segments_is_held_by_an_equation() -> None:
    """a_1 of the second segment is no coefficient: an equation of very large weight, as for inner knots."""
    whole = joined(3, 1)
    sigma = np.full(whole.values.shape, np.inf)
    sigma[5] = 0.0
    network, truth = block_with(
        with_options(whole, role="partial", sigma=sigma), fixed=True, noise_um=5.0, per_curve=20
    )
    found = adjust(network).curves[0]
    assert np.abs(found.values[5] - truth.curves[0][5]).max() < 1e-3
    assert np.sqrt(np.abs(found.values_dispersion[5]).max()) < 1e-3
    assert np.sqrt(np.abs(found.values_dispersion[6]).max()) > 0.05


@pytest.mark.parametrize("name", ["cubics", "bspline_2", "cardinal", "fourier", "conic", "circle"])
def test_control_curves_orient_images(name: str) -> None:
    """Every row fixed: orientations from the curves alone, no unknown of theirs, no condition."""
    one = joined(4, 1) if name == "cubics" else of_family(name)
    others = (
        tie("road", "natural_cubic", WINDING[:, [1, 0, 2]] + [-900.0, 1040.0, 5.0]),
        tie("ring", "circle", circle_rows(90.0)),
    )
    features = [with_options(f, role="control", sigma=np.zeros_like(f.values)) for f in (one, *others)]
    network, truth = block_with(*features, noise_um=0.0, per_curve=30)
    network = replace(
        network,
        points=replace(network.points, sigma=np.where(np.isfinite(network.points.sigma), 0.02, np.inf)),
    )
    result = adjust(network)
    assert result.statistics.conditions == 0
    assert np.abs(result.images.eop[:, 3:] - truth.eop[:, 3:]).max() < TOLERANCE
    for found, values in zip(result.curves, truth.curves, strict=True):
        np.testing.assert_allclose(found.values, values, rtol=0.0, atol=1e-9)
        assert np.abs(found.values_dispersion).max() == 0.0


@pytest.mark.parametrize("scale", [0.01, 30.0])
def test_another_frame_gives_the_same_residuals(scale: float) -> None:
    """All families turned, moved and in another unit of length; gauge and shape conditions with them."""
    network, _, first = together(5.0)
    rotation = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    shift = np.array([300.0, -200.0, 50.0])

    def moved(curve_values: FloatArray | None, positions: FloatArray) -> FloatArray | None:
        return None if curve_values is None else scale * curve_values @ rotation.T + positions * shift

    curves = []
    for curve in network.curves:
        positions = FAMILIES[curve.family].positions(len(curve.values))[:, None]
        values, reference = moved(curve.values, positions), moved(curve.reference, positions)
        parameters = curve.knot_parameters
        curves.append(replace(curve, values=values, reference=reference, knot_parameters=parameters))
    images = replace(
        network.images,
        rotation=rotation @ network.images.rotation,
        position=scale * network.images.position @ rotation.T + shift,
    )
    points = replace(
        network.points, xyz=moved(network.points.xyz, np.ones((1, 1))), sigma=scale * network.points.sigma
    )
    found = adjust(replace(network, images=images, points=points, curves=tuple(curves)))
    assert found.statistics.redundancy == first.statistics.redundancy
    assert found.statistics.conditions == first.statistics.conditions
    assert found.statistics.sigma0 == pytest.approx(first.statistics.sigma0, rel=1e-4)
    sigma = network.curve_observations.sigma[0, 0]
    assert np.abs(found.curve_residuals.across - first.curve_residuals.across).max() < 0.02 * sigma
    for feature, mine, yours in zip(ALL, found.curves, first.curves, strict=True):
        if feature.family != "polynomial_0":  # a point has no direction across
            assert mine.sigma_across_mean == pytest.approx(scale * yours.sigma_across_mean, rel=1e-2), (
                feature.id
            )
