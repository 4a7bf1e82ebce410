"""Figures: the same bytes for the same data, and the geometry that they claim."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.footprints import footprints
from splinebba_cli.report.plan_figure import block_plan
from splinebba_cli.report.result_data import ResultData, SplineSamples
from splinebba_cli.report.scale import round_length
from splinebba_cli.report.spline_figure import lateral_sigma
from tests.output.factory import make_result


def _samples(tangent: np.ndarray, major: float, minor: float, direction: list[float]) -> SplineSamples:
    u = np.linspace(0.0, 1.0, 5)
    return SplineSamples(u, u[:, None] * tangent, np.tile([major, minor], (5, 1)), np.tile(direction, (5, 1)))


def test_lateral_sigma_of_a_horizontal_line() -> None:
    normal, plan, profile = lateral_sigma(_samples(np.array([3.0, 0.0, 0.0]), 0.05, 0.02, [0.0, 0.0, 1.0]))
    np.testing.assert_allclose(normal, np.tile([0.0, 1.0], (5, 1)))
    np.testing.assert_allclose(plan, 0.02)
    np.testing.assert_allclose(profile, 0.05)


def test_lateral_sigma_of_a_turned_ellipse() -> None:
    s = np.sqrt(0.5)
    _, plan, profile = lateral_sigma(_samples(np.array([2.0, 0.0, 0.0]), 0.05, 0.02, [0.0, s, s]))
    np.testing.assert_allclose(plan, np.sqrt(0.5 * (0.05**2 + 0.02**2)))
    np.testing.assert_allclose(profile, plan)


def test_vertical_line_has_a_finite_band() -> None:
    _, plan, profile = lateral_sigma(_samples(np.array([0.0, 0.0, 4.0]), 0.05, 0.02, [1.0, 0.0, 0.0]))
    np.testing.assert_allclose(plan, 0.05)
    np.testing.assert_allclose(profile, 0.02)


def test_footprint_of_a_vertical_image() -> None:
    content = result_to_dict(make_result(images=1))
    content["images"][0] |= {"omega": 0.0, "phi": 0.0, "kappa": 0.0, "x": 100.0, "y": 200.0, "z": 1532.0}
    content["cameras"][0]["principal_point_mm"] = [0.0, 0.0]
    content["points"], content["splines"] = [{"x": 0.0, "y": 0.0, "z": 0.0, "role": "tie", "id": "a"}], []
    (corners,) = footprints(ResultData(content)).values()
    half = 115.0 * 1532.0 / 153.2
    np.testing.assert_allclose(corners.min(axis=0), [100 - half, 200 - half])
    np.testing.assert_allclose(corners.max(axis=0), [100 + half, 200 + half])


def test_images_that_look_aside_have_no_footprint() -> None:
    content = result_to_dict(make_result(images=1))
    content["images"][0] |= {"omega": 90.0, "phi": 0.0, "kappa": 0.0}
    assert footprints(ResultData(content)) == {}


def test_same_data_same_drawing() -> None:
    data = ResultData(result_to_dict(make_result()))
    assert block_plan(data) == block_plan(data)


@pytest.mark.parametrize(
    ("value", "rounded"), [(0.99, 0.5), (1.0, 1.0), (37.0, 20.0), (5.0, 5.0), (0.2, 0.2)]
)
def test_round_length(value: float, rounded: float) -> None:
    assert round_length(value) == pytest.approx(rounded)


def test_console_needs_no_matplotlib_and_no_jinja() -> None:
    code = (
        "import sys, splinebba_cli.report.text, splinebba_cli.report.build;"
        "import splinebba_cli.output.result_folder;"
        "print([m for m in ('matplotlib', 'jinja2', 'pyarrow', 'rich') if m in sys.modules])"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert output.stdout.strip() == "[]"
