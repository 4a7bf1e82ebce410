"""Elements of conics and closed splines in comparable terms, as the report shows them."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.output.tables import spline_coefficients_table, spline_locations_table
from splinebba_cli.project.result_schema import SPLINE
from splinebba_cli.report.blocks import Table
from splinebba_cli.report.shape_tables import shape_tables
from tests.core.family_features import ALL
from tests.core.free_curves import block_with


@pytest.fixture(scope="module")
def adjusted() -> Any:
    return adjust(block_with(*ALL, fixed=True, per_curve=12)[0])


@pytest.fixture(scope="module")
def splines(adjusted: Any) -> list[dict[str, Any]]:
    return list(result_to_dict(adjusted)["splines"])


def by_id(splines: list[dict[str, Any]], name: str) -> dict[str, Any]:
    return next(spline for spline in splines if spline["id"] == name)


def test_every_spline_follows_the_schema(splines: list[dict[str, Any]]) -> None:
    assert {spline["family"] for spline in splines} >= {"circle", "fourier", "bspline_3", "cardinal"}
    for spline in splines:
        jsonschema.validate(spline, SPLINE)


def test_segments_belong_to_polynomial_families_alone(splines: list[dict[str, Any]]) -> None:
    """Of trigonometric ones there are none; their rows, and control points, are given instead."""
    trigonometric = {"fourier", "conic", "circle"}
    for spline in splines:
        assert (spline["segments"] == []) == (spline["family"] in trigonometric), spline["id"]
        given = spline["family"] in trigonometric or spline["family"].startswith("bspline")
        assert ("values" in spline) == given, spline["id"]
    assert len(by_id(splines, "fourier")["values"]) == 7
    assert len(by_id(splines, "cubics-3-1")["segments"]) == 3


def test_closed_and_open(splines: list[dict[str, Any]]) -> None:
    """Whole conics and Fourier curves are closed without being told, arcs are open; closed ones have an ellipse."""
    closed = {spline["id"] for spline in splines if spline["closed"]}
    assert closed == {"closed", "tense-closed", "fourier", "conic", "circle"} | {
        f"bspline_{d}-closed" for d in (1, 2, 3)
    }
    assert closed == {spline["id"] for spline in splines if "ellipse" in spline}
    assert {s["id"] for s in splines if "conic" in s} == {"conic", "circle", "arc", "circular-arc"}


def test_tables_of_the_report(splines: list[dict[str, Any]]) -> None:
    elements, comparable = shape_tables(splines)
    assert isinstance(elements, Table) and isinstance(comparable, Table)
    assert [row[:2] for row in elements.rows] == [
        ("conic", "ellipse"), ("circle", "circle"), ("arc", "ellipse"), ("circular-arc", "circle"),
    ]  # fmt: skip
    assert all(len(row) == len(table.columns) for table in (elements, comparable) for row in table.rows)
    circle = next(row for row in comparable.rows if row[0] == "circle")
    names = [column.title for column in comparable.columns]
    assert circle[names.index("Semi-axis a")] == pytest.approx(60.0, abs=0.05)
    assert (
        shape_tables([spline for spline in splines if not spline["closed"] and "conic" not in spline]) == []
    )


def test_tables_of_the_result_folder(adjusted: Any, splines: list[dict[str, Any]]) -> None:
    """Places of points on trigonometric curves lie on them; the table of coefficients leaves them out."""
    table = {column.name: column.values for column in spline_locations_table(adjusted).columns}
    circle = by_id(splines, "circle")["conic"]
    rows = [i for i, name in enumerate(table["spline"]) if name == "circle"]
    assert len(rows) == 72
    for i in rows:
        square = sum((table[f"{axis}_m"][i] - circle["centre"][k]) ** 2 for k, axis in enumerate("xyz"))
        assert square == pytest.approx(circle["semi_axes"][0] ** 2, rel=1e-9)
        assert 0 <= table["segment"][i] < 4 and 0.0 <= table["t"][i] <= 1.0
    listed = set(spline_coefficients_table(adjusted).columns[0].values)
    assert "circle" not in listed and "cubics-3-1" in listed
