"""Residual vectors: their number, direction and length; what is out; which images are drawn."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from splinebba_cli.core.evidence import Revision
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.report import vectors_figure
from splinebba_cli.report.measured_image import MeasuredPoints
from splinebba_cli.report.vectors_figure import drawn_images, enlargement, image_vectors
from splinebba_cli.report.vectors_panel import Panel
from tests.output.factory import make_result, report_data
from tests.report.drawings import elements, titles


def _with_rejection() -> AdjustmentResult:
    weights = np.ones(24)
    weights[5] = 0.0
    return replace(make_result(), revision=Revision(point_weights=weights))


def test_one_vector_an_image_point() -> None:
    drawing = image_vectors(report_data(make_result()))
    vectors = [e for kind in ("v-point", "v-spline", "v-bad") for e in elements(drawing, kind)]
    assert len(vectors) == 24 + 60
    assert len(elements(drawing, "v-bad")) == 1  # w of 4.7 is beyond the critical value
    assert len(elements(drawing, "out")) == 0


def test_vector_of_a_point_points_from_measured_to_adjusted() -> None:
    result = make_result()
    residual = result.point_residuals.residual.copy()
    residual[:] = 0.0
    residual[0] = [0.003, 0.004]
    observed = replace(
        result.network.point_observations, photo_xy=np.zeros((24, 2)), image=np.zeros(24, dtype=np.int64)
    )
    result = replace(
        result,
        network=replace(result.network, point_observations=observed),
        point_residuals=replace(result.point_residuals, residual=residual),
    )
    data = report_data(result)
    factor = enlargement(data, MeasuredPoints.of(data))
    scale = 0.5 * 398.0 / 115.0  # drawing units a millimetre
    found = [e.get("d", "") for e in elements(image_vectors(data), "v-point")]
    (drawn,) = [d for d in found if not d.endswith("l0 0")]
    place, vector = re.fullmatch(r"M(\S+ \S+)l(\S+ \S+)", drawn).groups()  # type: ignore[union-attr]
    np.testing.assert_allclose([float(x) for x in place.split()], [200.0, 1.0 + 199.0], atol=0.06)
    expected = factor * scale * np.array([0.003, -0.004])
    np.testing.assert_allclose([float(x) for x in vector.split()], expected, atol=0.06)


def test_points_outside_of_the_format_are_seen_outside_of_the_frame() -> None:
    result = make_result()
    outside = result.network.point_observations.photo_xy.copy()
    outside[:, 1] = 150.0
    observed = replace(result.network.point_observations, photo_xy=outside)
    drawing = image_vectors(
        report_data(replace(result, network=replace(result.network, point_observations=observed)))
    )
    frame, dots = elements(drawing, "frame")[0], elements(drawing, "dots-point")[0]
    place = float(re.match(r"M\S+ ([\d.]+)h0", dots.get("d", "")).group(1))  # type: ignore[union-attr]
    assert 1.0 < place < float(frame.get("y", "nan"))


def test_vector_on_a_spline_stands_across_it() -> None:
    data = report_data(make_result())
    points = MeasuredPoints.of(data)
    rows = np.flatnonzero(points.on_spline)
    curve = make_result().curve_residuals
    np.testing.assert_allclose(points.vector[rows], curve.across[:, None] * curve.normal, atol=2e-7)


def test_rejected_observations_are_crossed() -> None:
    drawing = image_vectors(report_data(_with_rejection()))
    (cross,) = elements(drawing, "out")
    assert "rejected" in (cross[0].text or "")


def test_tips_say_feature_residual_and_w() -> None:
    result = make_result()
    found = titles(image_vectors(report_data(result)))
    feature = result.network.points.ids[result.network.point_observations.point[0]]
    v, w = 1e3 * result.point_residuals.residual[0], result.point_residuals.standardized[0]
    pixels = f"{v[0] / 12:+.2f}, {v[1] / 12:+.2f} px"
    expected = f"{feature}\nv {v[0]:+.2f}, {v[1]:+.2f} µm ({pixels})\nw {w[0]:+.2f}, {w[1]:+.2f}"
    assert expected in found


def test_factor_is_round_and_written() -> None:
    data = report_data(make_result())
    factor = enlargement(data, MeasuredPoints.of(data))
    assert f"{factor:.0e}"[0] in "125"
    assert f"enlarged {factor:,.0f} times".replace(",", "\u202f") in image_vectors(data)


def test_worst_images_first_and_no_more_than_the_page_can_carry(monkeypatch: pytest.MonkeyPatch) -> None:
    data = report_data(make_result(images=30, point_observations=300, curve_observations=300))
    points = MeasuredPoints.of(data)
    order = drawn_images(points)
    rms = [points.rms_mm(image) for image in order]
    assert rms == sorted(rms, reverse=True)
    assert len(order) == 30
    drawing = image_vectors(data)
    assert drawing.split("<details>")[0].count("<svg") == vectors_figure.SHOWN
    assert drawing.count("<details>") == 24
    monkeypatch.setattr(vectors_figure, "VECTORS", 200)
    assert drawn_images(points) == order[: len(drawn_images(points))]
    assert sum(len(points.rows[image]) for image in drawn_images(points)) <= 200


def test_images_with_very_many_points_show_those_with_the_largest_w(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Panel, "DRAWN", 5)
    drawing = image_vectors(report_data(make_result()))
    assert len(titles(drawing)) == 3 * (5 + 1)  # and the principal point of each
    assert len(elements(drawing, "v-bad")) == 1
    assert re.search(r"5 of \d+ points", drawing)


def test_same_bytes_and_nothing_without_residuals() -> None:
    data = report_data(make_result())
    assert image_vectors(data) == image_vectors(data)
    assert image_vectors(report_data(make_result(splines=0, points=0))) == ""
