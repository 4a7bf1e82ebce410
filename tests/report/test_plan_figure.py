"""The plan: everything that is drawn says what it is; ellipses have the size that their factor claims."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.read_table import ReadTable
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.figure_blocks import plan_blocks
from splinebba_cli.report.plan_ellipses import enlargement, projected_ellipses
from splinebba_cli.report.plan_figure import block_elevation, block_plan
from splinebba_cli.report.result_data import ResultData
from tests.output.factory import make_result, report_data
from tests.report.drawings import parsed, texts, titles


def _looking_aside(result: AdjustmentResult) -> AdjustmentResult:
    eop = result.images.eop.copy()
    eop[:, :3] = [np.pi / 2, 0.0, 0.0]
    rotation = rotation_object_from_photo(eop[:, :3])
    return replace(result, images=replace(result.images, eop=eop, rotation=rotation))


def test_every_image_spline_and_point_says_its_figures() -> None:
    result = make_result()
    found = titles(block_plan(report_data(result)))
    assert sum(text.startswith("footprint of image") for text in found) == 3
    station = next(text for text in found if text.startswith("image 762 (RMK)"))
    sigma = np.sqrt(result.images.dispersion[0, 3, 3])
    assert f"σ X {1e3 * sigma:.1f} mm" in station
    spline = next(text for text in found if text.startswith("spline kerb-1: tie"))
    assert "RMS across 6.00 µm" in spline
    assert sum(text.startswith("point P") for text in found) == 5


def test_scale_bar_arrow_and_legend() -> None:
    shown = texts(block_plan(report_data(make_result())))
    assert "N" in shown
    assert any(re.fullmatch(r"\d+ m", text) for text in shown)
    assert {"tie spline", "control spline", "camera station", "control point"} <= set(shown)


def test_ids_that_would_cover_others_are_left_out() -> None:
    data = report_data(make_result())
    for image, east in zip(data["images"], (0.0, 10.0, 200.0), strict=True):
        image.update(x=572_000.0 + east, y=5_378_400.0)
    names = [image["id"] for image in data["images"]]
    shown = [text.strip("\u00a0") for text in texts(block_plan(data))]
    assert [name in shown for name in names] == [True, False, True]


def test_no_ellipse_covers_the_block() -> None:
    alike = np.full(95, 0.1)
    assert enlargement(alike, 1000.0) == 200.0  # 20 m
    assert enlargement(np.concatenate([alike, np.full(5, 1.0)]), 1000.0) == 50.0  # at most 50 m, not 200


def test_hostile_ids_are_text() -> None:
    result = make_result()
    evil = "<b>&\"'\n\x1b]]>"
    images = replace(result.network.images, ids=(evil, "#101112", ' x="1.23456"'))
    drawing = block_plan(report_data(replace(result, network=replace(result.network, images=images))))
    parsed(drawing)
    found = titles(drawing)
    assert any("<b>&\"'\n\\x1b]]> (RMK)" in text for text in found)
    assert "<b>" not in drawing
    assert any(text.startswith("image #101112 ") for text in found)
    assert any(text.endswith('x="1.23456"') for text in texts(drawing))


def test_side_view_only_where_images_look_aside() -> None:
    assert block_elevation(report_data(make_result())) == ""
    aside = report_data(_looking_aside(make_result()))
    assert "Z [m]" in texts(block_elevation(aside))
    assert "Y" in texts(block_plan(aside))
    assert [block.figure for block in plan_blocks(aside)] == ["block_plan", "block_elevation"]  # type: ignore[union-attr]
    assert len(plan_blocks(report_data(make_result()))) == 1


def test_same_bytes_twice() -> None:
    data = report_data(_looking_aside(make_result()))
    assert block_plan(data) == block_plan(data)
    assert block_elevation(data) == block_elevation(data)


def test_nothing_but_images() -> None:
    drawing = block_plan(ResultData(result_to_dict(make_result(splines=0, points=0))))
    assert len([text for text in titles(drawing) if text.startswith("image ")]) == 3


@pytest.mark.parametrize(
    ("axes", "semi_axes"), [([0, 1], [3.0, 2.0]), ([0, 2], [3.0, 1.0]), ([1, 2], [2.0, 1.0])]
)
def test_ellipses_of_a_view(axes: list[int], semi_axes: list[float]) -> None:
    columns = {
        f"ellipsoid_{k + 1}_{axis}": [f"{float(k == i)}"] for k in range(3) for i, axis in enumerate("xyz")
    }
    columns |= {f"ellipsoid_{k}_m": [f"{4.0 - k}"] for k in (1, 2, 3)}
    found, directions = projected_ellipses(ReadTable(columns), axes)
    np.testing.assert_allclose(found[0], semi_axes)
    np.testing.assert_allclose(np.abs(directions[0]), np.eye(2), atol=1e-12)
