"""Check features: vectors with their factor, heights with their band, the 95 % limit along a check spline."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from splinebba_cli.core.result import CheckPoint, Checks, CheckSpline
from splinebba_cli.report.check_figures import check_points_figure, check_spline_figure, limits_95
from splinebba_cli.report.figure_blocks import check_point_blocks, check_spline_blocks
from splinebba_cli.report.result_data import ResultData
from tests.output.factory import make_result, report_data
from tests.report.drawings import texts, titles


def _data(*points: CheckPoint, splines: tuple[CheckSpline, ...] = ()) -> ResultData:
    return report_data(replace(make_result(), checks=Checks(points, splines)))


GOOD = CheckPoint("P4", np.array([0.01, -0.02, 0.04]), np.array([0.015, 0.015, 0.03]), 1.1)


def test_differences_and_factor() -> None:
    drawing = check_points_figure(_data(GOOD))
    tip = "check point P4\nΔX 10.0 mm, σ 15.0 mm\nΔY -20.0 mm, σ 15.0 mm\nΔZ 40.0 mm, σ 30.0 mm"
    assert titles(drawing).count(tip) >= 2
    (title,) = [text for text in texts(drawing) if text.startswith("ΔX, ΔY enlarged")]
    assert re.fullmatch(r"ΔX, ΔY enlarged [125][0\u202f]* times", title)
    assert "ΔZ [mm]" in texts(drawing)
    assert "var(--bad)" not in drawing


def test_vectors_go_from_the_given_place_towards_the_adjusted_one() -> None:
    """X to the right, Y and Z up: the axis of the drawing points down."""
    line = r"<title>check point P4[^<]*</title>\n<path d=\"M ([\d.]+) ([\d.]+) \nL ([\d.]+) ([\d.]+)"
    ends = np.array(re.findall(line, check_points_figure(_data(GOOD))), dtype=float)
    (right, down), (_, height) = ends[:, 2:] - ends[:, :2]
    assert right > 1.0 and height < -1.0
    assert down / right == pytest.approx(0.02 / 0.01, abs=0.01)


def test_coordinates_of_millions_of_metres_are_written_out() -> None:
    shown = texts(check_points_figure(_data(GOOD)))  # northings of 5378 km
    assert not [text for text in shown if re.fullmatch(r"1e\d+", text)]
    assert [text for text in shown if re.fullmatch(r"537\d{4}", text)]


def test_failed_points_are_red() -> None:
    assert "var(--bad)" in check_points_figure(_data(replace(GOOD, passed=False)))


def test_no_check_points() -> None:
    assert check_points_figure(_data()) == ""


def test_alt_texts_have_the_main_number() -> None:
    data = report_data(make_result())
    assert "Z 40.0 mm" in check_point_blocks(data["checks"])[0].alt  # type: ignore[union-attr]
    assert "largest 50.0 mm" in check_spline_blocks(data["checks"]["splines"])[0].alt  # type: ignore[union-attr]


def test_limit_along_a_check_spline() -> None:
    critical = np.sqrt(chi2.ppf(0.95, 2) / 2.0)
    np.testing.assert_allclose(limits_95(np.array([0.02]), np.array([critical])), 0.02, rtol=1e-4)
    assert np.isnan(limits_95(np.array([0.02]), np.array([np.nan])))


def test_distances_along_a_check_spline() -> None:
    spline = CheckSpline(
        "kerb-9",
        np.array([0.01, np.nan, 0.05]),
        0.036,
        0.05,
        0.02,
        normalized=np.array([0.5, np.nan, 3.0]),
        critical=2.0,
    )
    drawing = check_spline_figure(_data(splines=(spline,)), "kerb-9")
    assert [text for text in titles(drawing) if text.startswith("given")] == [
        "given point 1\ndistance 10.0 mm",
        "given point 3\ndistance 50.0 mm",
    ]
    assert "var(--bad)" in drawing
    nowhere = replace(spline, distance=np.full(3, np.nan))
    assert check_spline_figure(_data(splines=(nowhere,)), "kerb-9") == ""


@pytest.mark.parametrize("count", [3, 20])
def test_of_many_check_splines_the_worst(count: int) -> None:
    splines = [{"id": f"s{k}", "rms": 0.01, "max": 0.01 * k} for k in range(count)]
    blocks = check_spline_blocks(splines)
    figures = [block.subject for block in blocks if hasattr(block, "subject")]
    assert figures == [f"s{k}" for k in range(count - 1, max(count - 13, -1), -1)]
    assert len(blocks) - len(figures) == (count > 12)
