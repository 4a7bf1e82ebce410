"""Measured parts of a spline: one row an image, one mark a point, the longest gap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.report.figure_blocks import spline_blocks
from splinebba_cli.report.rays_figure import longest_gap, rays_figure
from splinebba_cli.report.result_data import ResultData, SplineSamples
from tests.output.factory import make_result, report_data
from tests.report.drawings import elements, texts, titles


def test_every_measured_point_has_a_mark() -> None:
    result = make_result()
    rows = result.network.curve_observations
    drawing = rays_figure(report_data(result), "kerb-1")
    marks = elements(drawing, "rays")
    images = np.unique(rows.image[rows.curve == 0])
    assert len(marks) == len(images)
    assert sum(mark.get("d", "").count("M") for mark in marks) == (rows.curve == 0).sum()
    assert {result.network.images.ids[i] for i in images} <= set(texts(drawing))
    assert sum(text.startswith("knot ") for text in titles(drawing)) == 5


def test_row_tells_its_longest_gap() -> None:
    data = _straight([0.0, 1.0, 4.0, 9.0], closed=False)
    assert "image a: 4 points\nfrom 0.00 m to 9.00 m\nlongest gap 5.00 m" in "\n".join(
        titles(rays_figure(data, "s"))
    )


@pytest.mark.parametrize(
    ("u", "closed", "gap"),
    [([0.0, 1.0, 4.0], False, 6.0), ([5.0, 6.0, 9.0], False, 5.0), ([5.0, 6.0, 9.0], True, 16.0)],
)
def test_gaps_at_the_ends_and_over_the_start_of_a_closed_spline(
    u: list[float], closed: bool, gap: float
) -> None:
    """The closed one goes ten metres there and ten metres back, unmeasured, to its start."""
    data = _straight(u, closed=closed)
    assert longest_gap(data, data["splines"][0]) == pytest.approx(gap)


def _straight(u: list[float], *, closed: bool) -> ResultData:
    """A spline along X, ten metres long, seen in one image."""
    spline = {"id": "s", "closed": closed, "knot_parameters": [0.0, 10.0]}
    data = ResultData({"splines": [spline], "images": [{"id": "a"}]})
    along = np.linspace(0.0, 10.0, 11)
    xyz = np.column_stack([along, np.zeros((11, 2))])
    data.samples_by_spline = {"s": SplineSamples(along, xyz, np.zeros((11, 2)), np.zeros((11, 3)))}
    data.locations_by_spline = {"s": {"a": np.array(u)}}
    return data


def test_every_spline_has_both_figures_and_an_alt_with_its_numbers() -> None:
    data = report_data(make_result())
    blocks = spline_blocks(data)
    assert [block.figure for block in blocks] == ["spline", "rays"] * 2  # type: ignore[union-attr]
    assert "longest gap" in blocks[1].alt  # type: ignore[union-attr]
    assert "mm in the mean" in blocks[0].alt  # type: ignore[union-attr]


def test_hostile_ids_and_no_samples() -> None:
    result = make_result()
    images = replace(result.network.images, ids=("<script>", "&", "\x00"))
    result = replace(result, network=replace(result.network, images=images))
    drawing = rays_figure(report_data(result), "kerb-1")
    assert "<script" not in drawing
    assert "&lt;script&gt;" in drawing
    assert "\\x00" in drawing
    assert rays_figure(ResultData(report_data(result).content), "kerb-1") == ""
