"""Redundancy numbers and minimal detectable biases in block and format; standardized residuals; variance components."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.report.format_map import format_cells, format_map
from splinebba_cli.report.redundancy_map import redundancy_map
from splinebba_cli.report.residual_figure_blocks import histogram_blocks, reliability_blocks, variance_blocks
from splinebba_cli.report.residual_figures import histogram, standardized
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.value_classes import quantile_classes, redundancy_classes
from splinebba_cli.report.variance_figure import variance_figure
from tests.output.factory import make_result, report_data
from tests.report.drawings import texts, titles


def test_points_show_the_mean_over_their_rays() -> None:
    result = make_result()
    rays = result.network.point_observations.point == 0
    r = result.point_residuals.redundancy[rays].mean(axis=1)
    found = titles(redundancy_map(report_data(result)))
    assert f"point P1: mean r {r.mean():.2f}\n{rays.sum()} rays, least r {r.min():.2f}" in found


def test_all_image_points_on_splines_are_in_a_part() -> None:
    found = [
        text for text in titles(redundancy_map(report_data(make_result()))) if text.startswith("spline ")
    ]
    assert sum(int(text.split("\n")[1].split()[0]) for text in found) == 60


def test_classes_count_from_good_to_bad() -> None:
    classes = redundancy_classes()
    np.testing.assert_array_equal(classes.of(np.array([0.95, 0.8, 0.7, 0.05])), [0, 0, 1, 5])
    assert classes.names()[0] == "≥ 0.8"
    assert classes.names()[-1] == "< 0.1"
    classes = quantile_classes(np.arange(1.0, 61.0), "MDB [µm]")
    assert classes.of(np.array([1.0, 60.0])).tolist() == [0, 5]
    limits = quantile_classes(np.full(9, 24.0), "").limits
    assert list(limits) == sorted(set(limits))
    alike = quantile_classes(np.linspace(23.8, 24.2, 60), "")  # noise is no pattern
    assert set(alike.of(np.linspace(23.8, 24.2, 60)).tolist()) <= {0, 1}


def test_cells_of_the_format() -> None:
    result = make_result(curve_observations=0, splines=0, point_observations=4)
    observed = replace(
        result.network.point_observations,
        photo_xy=np.array([[-100.0, 100.0], [-101, 101], [100, 100], [0.1, -100]]),
    )
    data = report_data(replace(result, network=replace(result.network, point_observations=observed)))
    found = format_cells(data, "RMK")
    assert found is not None
    (x_edges, y_edges), count, r, bias = found
    assert (x_edges[0], x_edges[-1], len(y_edges)) == (-115.0, 115.0, 9)
    assert (count[7, 0], count[7, 7], count[0, 4], count.sum()) == (2, 1, 1, 4)
    both = result.point_residuals
    assert r[7, 0] == pytest.approx(both.redundancy[:2].mean(), abs=1e-6)
    expected = np.median(1e3 * both.reliability.minimal_detectable_bias[:2].mean(axis=1))
    assert bias[7, 0] == pytest.approx(expected, abs=1e-3)
    assert np.isnan(r[3, 3])
    drawing = format_map(data, "RMK")
    assert len(titles(drawing)) == 2 * 3
    assert {"Mean redundancy number r", "Median MDB [µm]"} <= set(texts(drawing))
    assert f"Mean redundancy number r {r[7, 0]:.3g}\n2 image points" in titles(drawing)
    assert f"Median MDB [µm] {bias[7, 0]:.3g}\n2 image points" in titles(drawing)


def test_many_cameras_few_maps() -> None:
    data = report_data(make_result())
    cameras = [{**data["cameras"][0], "id": f"c{k}"} for k in range(9)]
    content = {**data.content, "cameras": cameras}
    content["images"] = [{**image, "camera": f"c{k}"} for k, image in enumerate(data["images"])]
    many = ResultData(content)
    many.residuals, many.image_points = data.residuals, data.image_points
    blocks = [block for block in reliability_blocks(many) if getattr(block, "figure", "") == "format_map"]
    assert len(blocks) == 3
    assert format_map(many, "c8") == ""


def test_histogram_and_quantiles_count_all_tested_values() -> None:
    data = report_data(make_result())
    assert {name: len(values) for name, values in standardized(data).items()} == {"points": 48, "splines": 60}
    drawing = histogram(data)
    assert any(text.startswith("points: 48, rms") for text in texts(drawing))
    assert "quantile of N(0, 1)" in texts(drawing)
    assert histogram(data) == drawing
    rms = np.sqrt(np.mean(standardized(data)["points"] ** 2))
    assert f"points {rms:.2f}" in histogram_blocks(data)[0].alt  # type: ignore[union-attr]


_GROUP = {
    "group": "spline points", "kind": "spline", "observations": 60, "redundancy": 40.0, "sigma0": 1.0,
    "sigma0_sigma": 0.1, "factor": 1.5, "passed": True,
}  # fmt: skip


def test_variance_components_are_held_against_the_declared_sigma() -> None:
    groups = [
        _GROUP,
        {**_GROUP, "group": "points", "kind": "point", "sigma0": 0.9, "factor": 1.0, "passed": False},
    ]
    data = ResultData({"variance_components": [*groups, {**_GROUP, "sigma0": None}]})
    drawing = variance_figure(data)
    found = titles(drawing)
    assert found[0].startswith("spline points (spline)\nestimated / declared 1.500 ± 0.294")
    assert len(found) == 2
    assert drawing.count("var(--bad)") > 0
    assert "0.90 to 1.50" in variance_blocks(groups)[0].alt  # type: ignore[union-attr]
    assert variance_figure(ResultData({"variance_components": [{**_GROUP, "sigma0": None}]})) == ""


def test_same_bytes_and_nothing_without_residuals() -> None:
    data = report_data(make_result())
    assert redundancy_map(data) == redundancy_map(data)
    assert format_map(data, "RMK") == format_map(data, "RMK")
    empty = report_data(make_result(splines=0, points=0))
    assert redundancy_map(empty) == format_map(empty, "RMK") == ""
