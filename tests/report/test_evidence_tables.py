"""Tables of single observations: where they were measured, marked by their own test, with effects that there are."""

from __future__ import annotations

from typing import Any

import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.report.blocks import Table
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report, key_facts
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.output.factory import report_data


@pytest.fixture(scope="module")
def block() -> AdjustmentResult:
    return adjust(simulate_block("six-image-mixed", 2)[0])


def _table(data: ResultData, caption: str) -> Table:
    blocks = [block for section in build_report(data).sections for block in section.blocks]
    return next(each for each in blocks if isinstance(each, Table) and each.caption.startswith(caption))


def test_largest_residuals_tell_where_they_were_measured(block: AdjustmentResult) -> None:
    table = _table(report_data(block), "Largest standardized residuals")
    names = [column.title for column in table.columns]
    first = dict(zip(names, table.rows[0], strict=True))
    network = block.network
    if first["Kind"] == "spline":
        observed: Any = network.curve_observations
        feature = network.curves[observed.curve[first["Row"] - 1]].id
    else:
        observed = network.point_observations
        feature = network.points.ids[observed.point[first["Row"] - 1]]
    row = first["Row"] - 1
    assert (network.images.ids[observed.image[row]], feature) == (first["Image"], first["Feature"])
    assert [first["x"], first["y"]] == pytest.approx(observed.photo_xy[row].tolist(), abs=1e-6)


def test_control_is_marked_by_its_test(block: AdjustmentResult) -> None:
    data = report_data(block)
    table = _table(data, "Residuals of coordinates")
    w = [row[-1] for row in table.rows]
    critical = data["tests"]["critical"]
    assert table.marked == frozenset(
        k for k, each in enumerate(w) if each is not None and abs(each) > critical
    )
    data.content["tests"]["critical"] = 1e-6
    assert len(_table(data, "Residuals of coordinates").marked) == sum(bool(each) for each in w) > 0


def test_effects_on_orientations_are_left_out_where_images_are_fixed(block: AdjustmentResult) -> None:
    data = report_data(block)
    for one in data["tests"]["influences"]:
        one["orientation"]["sigmas"] = 0.0
    columns = [c.title for c in _table(data, "Observations whose undetected").columns]
    assert columns == ["Observation", "r", "MDB", "Object", "at"]


def test_no_headline_of_stations_that_are_fixed(block: AdjustmentResult) -> None:
    data = report_data(block)
    assert "Largest σ of a station" in [fact.label for fact in key_facts(data).items]
    for image in data["images"]:
        image["sigma"] = dict.fromkeys(image["sigma"], 0.0)
    assert "Largest σ of a station" not in [fact.label for fact in key_facts(data).items]
