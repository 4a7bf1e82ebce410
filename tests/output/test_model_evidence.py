"""Variance components, tests of groups and systematic effects in the files and in the reports."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from typing import Any

import jsonschema
import numpy as np
import pytest

from benchmarks.variance_components import block, radial, shifted_chain, two_groups
from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import Evidence
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.model_evidence_tables import model_evidence_tables
from splinebba_cli.output.result_json import result_json_text, result_to_dict
from splinebba_cli.project.result_schema import result_schema
from splinebba_cli.report.blocks import FigureBlock, Table
from splinebba_cli.report.grid_figure import residual_grid
from splinebba_cli.report.model_sections import groups_section, systematic_section, variance_section
from splinebba_cli.report.result_data import ResultData


@cache
def wrong() -> AdjustmentResult:
    """A block with a lens that lacks 120 µm of distortion and one chain on a wrong edge."""
    return adjust(shifted_chain(radial(block(1), 120.0), 40.0))


@cache
def content() -> dict[str, Any]:
    return dict(json.loads(result_json_text(result_to_dict(wrong()))))


def table_of(blocks: tuple[object, ...]) -> Table:
    (table,) = [each for each in blocks if isinstance(each, Table)]
    return table


def test_the_parts_of_result_json_follow_the_schema() -> None:
    schema = result_schema()["properties"]
    for part in ("variance_components", "group_tests", "systematic"):
        jsonschema.validate(content()[part], schema[part])
    groups = content()["group_tests"]
    assert groups["tested"] == len(groups["tests"]) <= groups["possible"]
    (grid,) = content()["systematic"]["grids"]
    shape = np.array(grid["mean_mm"], dtype=float).shape
    assert shape == (len(grid["y_edges_mm"]) - 1, len(grid["x_edges_mm"]) - 1, 2)
    assert np.sum(grid["count"]) == 248 + 660  # two equations a point, one across a spline


def test_tables_are_written_where_they_have_rows() -> None:
    tables = {table.name: table for table in model_evidence_tables(wrong())}
    assert len(tables["group_tests"]) == len(wrong().evidence.groups)
    assert len(tables["systematic_effects"]) == len(wrong().evidence.systematic)
    assert model_evidence_tables(replace(wrong(), evidence=Evidence())) == ()


def test_the_worst_group_is_the_first_and_marked() -> None:
    table = table_of(groups_section(ResultData(content())).blocks)
    assert 0 in table.marked
    ratio = [float(row[5]) / float(row[6]) for row in table.rows]  # type: ignore[arg-type]
    assert ratio == sorted(ratio, reverse=True)


def test_a_lens_that_lacks_distortion_is_named_with_its_size() -> None:
    """120 µm at 160 mm within four of its σ, and the K1 that takes it out has the other sign."""
    table = table_of(systematic_section(ResultData(content())).blocks)
    assert table.rows[0][:2] == ("radial trend", "camera camera") and 0 in table.marked
    (effect,) = [each for each in wrong().evidence.systematic if each.kind == "radial trend"]
    assert effect.estimate == pytest.approx(120.0, abs=45.0)
    (problem,) = [each for each in wrong().problems if each.code == "SBB548" and "radial" in each.message]
    assert problem.severity == "warning" and "K1 = −" in problem.message


def test_the_grid_is_a_figure_of_its_camera() -> None:
    (figure,) = [b for b in systematic_section(ResultData(content())).blocks if isinstance(b, FigureBlock)]
    drawing = residual_grid(ResultData(content()), figure.subject)
    assert drawing.startswith("<svg") and "var(--bad)" in drawing  # arrows that leave their ellipse
    assert drawing == residual_grid(ResultData(content()), figure.subject)
    assert residual_grid(ResultData(content()), "another") == ""


def test_estimated_factors_are_shown_as_such() -> None:
    result = adjust(two_groups(1))
    table = table_of(variance_section(ResultData(result_to_dict(result))).blocks)
    verdicts = {str(row[0]): row[-1] for row in table.rows}
    assert verdicts["fine"] == verdicts["coarse"] == "σ estimated"
    assert "global test" in table.note


def test_results_without_this_evidence_have_no_sections() -> None:
    """Folders written by earlier versions."""
    old = {key: value for key, value in content().items() if key not in ("group_tests", "systematic")}
    del old["variance_components"]
    for section in (variance_section, groups_section, systematic_section):
        assert section(ResultData(old)).blocks == ()
