"""Correlations of orientation unknowns: values, fixed unknowns, one matrix or small maps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.quality.full_dispersion import EOP
from splinebba_cli.core.result import AdjustmentResult, DispersionBlocks
from splinebba_cli.report.correlation_figure import MAPS, correlation_figure
from splinebba_cli.report.figure_blocks import correlation_blocks
from splinebba_cli.report.orientation_correlations import OrientationCorrelations
from splinebba_cli.report.result_data import ResultData
from tests.output.factory import make_result, report_data
from tests.report.drawings import elements, titles


def _full(result: AdjustmentResult) -> AdjustmentResult:
    rng = np.random.default_rng(4)
    factor = rng.normal(size=(18, 40))
    names = tuple(f"image {image} {name}" for image in result.network.images.ids for name in EOP)
    return replace(result, dispersion=DispersionBlocks(names, factor @ factor.T))


def test_small_maps_give_pair_and_value() -> None:
    result = make_result()
    drawing = correlation_figure(report_data(result))
    assert "image 763 ω\nimage 763 Y₀\nr = -0.983" in titles(drawing)
    assert len(titles(drawing)) == 3 * 30
    assert len(elements(drawing, "self")) == 3 * 6


def test_whole_matrix_has_the_correlations_between_images() -> None:
    result = _full(make_result())
    found = titles(correlation_figure(report_data(result, full=True)))
    assert len(found) == 18 * 17
    covariance = result.dispersion.matrix  # type: ignore[union-attr]
    r = covariance[0, 9] / np.sqrt(covariance[0, 0] * covariance[9, 9])
    assert f"image 762 ω\nimage 763 X₀\nr = {r:+.3f}" in found


def test_fixed_unknowns_have_no_correlation() -> None:
    result = make_result()
    dispersion = result.images.dispersion.copy()
    dispersion[0] = 0.0
    result = replace(result, images=replace(result.images, dispersion=dispersion))
    drawing = correlation_figure(report_data(result))
    assert not any("image 762" in text for text in titles(drawing))
    assert len(elements(drawing, "none")) == 36
    fixed = replace(result, images=replace(result.images, dispersion=np.zeros((3, 6, 6))))
    assert correlation_figure(report_data(fixed)) == ""
    assert correlation_blocks(report_data(fixed)) == []


def test_of_many_images_the_most_correlated_ones() -> None:
    data = report_data(make_result(images=40))
    found = OrientationCorrelations.of(data)
    assert found is not None
    drawing = correlation_figure(data)
    assert len(elements(drawing, "self")) == 6 * MAPS
    worst = found.images[int(found.largest().argmax())]
    assert any(text.startswith(f"image {worst} ") for text in titles(drawing))
    (block,) = correlation_blocks(data)
    assert f"of image {worst}" in block.alt  # type: ignore[union-attr]
    assert "the 12 images with the largest |r| of 40" in block.caption  # type: ignore[union-attr]


def test_no_dispersion_no_figure() -> None:
    data = report_data(make_result())
    assert correlation_figure(ResultData(data.content)) == ""
    assert correlation_figure(data) == correlation_figure(data)
