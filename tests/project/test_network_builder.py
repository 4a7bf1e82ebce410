"""Local origin, units, settings and roles of the network."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from splinebba_cli.core.network import Network
from splinebba_cli.project.loading import load_project
from tests.project.project_text import PROJECT, changed, written


def network(folder: Path, text: str = PROJECT) -> Network:
    return load_project(written(folder, text)).network


def far(text: str = PROJECT) -> str:
    """The example, moved by 7 672 016.87 m in x and 512 400 m in y."""
    text = changed("x: 0, y: 0, z: 1000", "x: 7672016.87, y: 512400, z: 1000", text)
    text = changed("x: 500, y: 0, z: 1000", "x: 7672516.87, y: 512400, z: 1000", text)
    text = changed("xyz: [100, 100, 10]", "xyz: [7672116.87, 512500, 10]", text)
    for x, y in ((0, 0), (100, 10), (200, 20)):
        text = changed(f"      {x} {y} ", f"      {x + 7672016.87} {y + 512400} ", text)
    for x, y in ((0, 100), (100, 110), (200, 120)):
        text = changed(f"[{x}, {y}, ", f"[{x + 7672016.87}, {y + 512400}, ", text)
    return text


def test_small_coordinates_are_not_shifted(tmp_path: Path) -> None:
    knots = "[[0, 100, 0], [100, 110, 5], [200, 120, 0]]"
    text = changed(knots, "[[4000, 100, 0], [4100, 110, 5], [9200, 120, 0]]")
    assert network(tmp_path, text).origin.tolist() == [0.0, 0.0, 0.0]


def test_origin_is_a_round_number_near_the_control(tmp_path: Path) -> None:
    found = network(tmp_path, far())
    assert found.origin.tolist() == [7_672_000.0, 513_000.0, 0.0]
    np.testing.assert_allclose(
        found.points.xyz[0] + found.origin, [7672116.87, 512500.0, 10.0], rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(
        found.images.position[0] + found.origin, [7672016.87, 512400.0, 1000.0], atol=1e-9
    )
    np.testing.assert_allclose(found.images.prior[0, 3:], found.images.position[0])
    np.testing.assert_allclose(
        found.curves[1].values[0] + found.origin, [7672016.87, 512500.0, 0.0], atol=1e-9
    )
    assert np.abs(found.curves[0].values).max() < 2000.0


def test_declared_origin(tmp_path: Path) -> None:
    found = network(tmp_path, changed("  name: example\n", "  name: example\n  local_origin: [10, 20, 30]\n"))
    assert found.origin.tolist() == [10.0, 20.0, 30.0]
    assert found.points.xyz[0].tolist() == [90.0, 80.0, -20.0]


@pytest.mark.parametrize(("unit", "quarter"), [("deg", 90), ("gon", 100), ("rad", math.pi / 2)])
def test_angle_units(unit: str, quarter: float, tmp_path: Path) -> None:
    text = changed("angle_unit: deg", f"angle_unit: {unit}")
    text = changed(
        "omega: 1, phi: 2, kappa: 90}",
        f"omega: 0, phi: 0, kappa: {quarter}}}, sigma: {{kappa: {quarter}}}",
        text,
    )
    images = network(tmp_path, text).images
    np.testing.assert_allclose(images.rotation[1], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    assert images.prior_sigma[1, 2] == pytest.approx(math.pi / 2)
    assert images.prior[1, 2] == pytest.approx(math.pi / 2)


def test_settings(tmp_path: Path) -> None:
    text = PROJECT + (
        "adjustment:\n  datum: minimal\n  max_iterations: 9\n  alpha: 0.01\n  sigma0_prior: 2\n"
        "  gauge_sigma_m: 0.5\n"
        "  scale_dispersion: no\n  staged: false\n  knots: {spacing_m: 3, insert: true, drop: yes}\n"
    )
    s = network(tmp_path, text).settings
    assert (s.datum, s.max_iterations, s.alpha, s.sigma0_prior, s.gauge_sigma_m) == (
        "minimal",
        9,
        0.01,
        2.0,
        0.5,
    )
    assert (s.scale_dispersion, s.staged) == (False, False)
    assert (s.knots.spacing_m, s.knots.insert, s.knots.drop) == (3.0, True, True)


def test_sigma_of_check_points(tmp_path: Path) -> None:
    """It belongs to the given coordinates; the unknown coordinates are free. Without it they are exact."""
    text = changed("{id: t1, role: tie}", "{id: t1, role: check, xyz: [1, 2, 3], sigma: [0.1, fixed, 0.3]}")
    points = network(tmp_path, text).points
    assert np.isinf(points.sigma[1]).all()
    assert points.check_sigma[1].tolist() == [0.1, 0.0, 0.3]
    assert np.isnan(points.check_sigma[0]).all()
    exact = network(tmp_path, changed(", sigma: [0.1, fixed, 0.3]", "", text)).points
    assert exact.check_sigma[1].tolist() == [0.0, 0.0, 0.0]


def test_a_check_spline_is_compared_with_its_knots(tmp_path: Path) -> None:
    curve = network(tmp_path, changed("    role: tie\n", "    role: check\n")).curves[0]
    assert curve.check_values is not None
    np.testing.assert_array_equal(curve.check_values, curve.values)
    assert np.isinf(curve.sigma).all()


def test_units_of_sigma(tmp_path: Path) -> None:
    for declared, expected in (("sigma_mm: 0.5", 0.5), ("sigma_um: [5, 7]", 0.005)):
        text = changed(
            "      sigma_um: 5\n      columns: [image, spline",
            f"      {declared}\n      columns: [image, spline",
        )
        assert network(tmp_path, text).curve_observations.sigma[0, 0] == pytest.approx(expected)
    assert network(tmp_path, text).curve_observations.sigma[0, 1] == pytest.approx(0.007)
    text = changed(
        "image_coordinates: photo_mm\n", "image_coordinates: photo_mm\n    pixel_size_mm: [0.01, 0.02]\n"
    )
    text = changed(
        "      sigma_um: 5\n      columns: [image, spline",
        "      sigma_px: 0.5\n      columns: [image, spline",
        text,
    )
    assert network(tmp_path, text).curve_observations.sigma[0].tolist() == [0.005, 0.01]
