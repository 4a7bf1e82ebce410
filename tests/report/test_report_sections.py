"""What the report says: the verdict first, then problems; figures with the right unit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from splinebba_cli.core.prior_residuals import PriorResiduals
from splinebba_cli.core.result import AdjustmentResult, GlobalTest
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.blocks import (
    Column,
    Facts,
    FigureBlock,
    Note,
    ProblemList,
    Report,
    Table,
    cell_text,
)
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report
from tests.output.factory import make_result


def _report(result: AdjustmentResult | None = None, **changes: Any) -> Report:
    return build_report(ResultData(result_to_dict(result or make_result(**changes))))


def _table(report: Report, caption: str) -> Table:
    return next(
        block
        for section in report.sections
        for block in section.blocks
        if isinstance(block, Table) and block.caption.startswith(caption)
    )


def _with_test(statistic: float, passed: bool) -> AdjustmentResult:
    result = make_result(problems=())
    test = GlobalTest(statistic, 101.2, 164.6, 0.05, passed)
    return replace(result, statistics=replace(result.statistics, global_test=test))


def test_problems_come_first_and_the_worst_on_top() -> None:
    problems = make_result().problems
    error = replace(problems[0], severity="error", code="SBB510")
    report = _report(problems=(*problems[::-1], error))
    assert report.sections[0].id == "problems"
    block = report.sections[0].blocks[0]
    assert isinstance(block, ProblemList)
    assert [item.severity for item in block.items] == ["error", "warning", "info"]


@pytest.mark.parametrize(
    ("result", "tone", "words"),
    [
        (make_result(problems=()), "good", "accepted"),
        (make_result(), "warning", "1 warning"),
        (_with_test(200.0, False), "warning", "larger than the declared"),
        (_with_test(50.0, False), "warning", "smaller than the declared"),
        (make_result(converged=False), "bad", "Not converged"),
        (
            make_result(problems=(replace(make_result().problems[0], severity="error"),)),
            "bad",
            "not acceptable",
        ),
    ],
)
def test_verdict(result: AdjustmentResult, tone: str, words: str) -> None:
    verdict = _report(result).verdict
    assert verdict.tone == tone
    assert words in f"{verdict.headline} {verdict.detail}"


def test_no_redundancy_is_never_accepted() -> None:
    result = make_result(problems=())
    statistics = replace(result.statistics, redundancy=0, sigma0=np.nan, global_test=None)
    verdict = _report(replace(result, statistics=statistics)).verdict
    assert verdict.tone == "warning"
    assert "redundancy is 0" in verdict.detail


def test_orientation_in_metres_degrees_and_small_units() -> None:
    result = make_result()
    table = _table(_report(result), "Adjusted exterior")
    headings = [column.heading for column in table.columns]
    assert headings[1:7] == ["X [m]", "Y [m]", "Z [m]", "ω [°]", "φ [°]", "κ [°]"]
    assert headings[7:] == ["σ X [mm]", "σ Y [mm]", "σ Z [mm]", "σ ω [″]", "σ φ [″]", "σ κ [″]"]
    row = table.rows[0]
    sigma = np.sqrt(np.diag(result.images.dispersion[0]))
    assert row[4] == pytest.approx(np.degrees(result.images.eop[0, 0]))
    assert row[7] == pytest.approx(1e3 * sigma[3])
    assert row[10] == pytest.approx(3600 * np.degrees(sigma[0]))
    assert table.marked == {1}


def test_along_curve_figures_are_marked_as_datum_dependent() -> None:
    section = next(section for section in _report().sections if section.id == "splines")
    table = section.blocks[0]
    assert isinstance(table, Table)
    assert table.columns[-1].help == "datum-dependent"
    assert any(isinstance(block, Note) and "datum-dependent" in block.text for block in section.blocks)


def test_lee_coefficients_of_every_segment() -> None:
    result = make_result()
    table = _table(_report(result), "Coefficients")
    assert len(table.rows) == 2 * 4 * 3
    row = table.rows[4]  # first spline, second segment, Y
    assert row[:5] == ("kerb-1", 1, 1.0, 2.0, "Y (b)")
    np.testing.assert_array_equal(row[5:9], result.curves[0].segments.coefficients[1, :, 1])


def test_conditions_with_their_shares() -> None:
    section = next(section for section in _report().sections if section.id == "conditions")
    facts = section.blocks[0]
    assert isinstance(facts, Facts)
    assert [fact.value for fact in facts.items] == ["12", "3", "0.70 %", "1.30 %"]


def test_of_many_splines_the_least_precise_get_figures() -> None:
    result = make_result(splines=43)
    curves = list(result.curves)
    curves[41] = replace(curves[41], sigma_across_max=9.0)
    section = next(
        section
        for section in _report(replace(result, curves=tuple(curves))).sections
        if section.id == "splines"
    )
    texts = [block.text for block in section.blocks if isinstance(block, Note)]
    assert any("20 splines with the largest σ across of 43" in text for text in texts)
    subjects = [block.subject for block in section.blocks if isinstance(block, FigureBlock)]
    assert len(subjects) == 20
    assert "kerb-42" in subjects


def test_empty_sections_are_left_out() -> None:
    result = make_result(splines=0, points=0, prior_residuals=PriorResiduals.of_rows(()), problems=())
    ids = [section.id for section in _report(result).sections]
    assert not {"splines", "points", "priors", "residuals"} & set(ids)


@pytest.mark.parametrize(
    ("column", "cell", "text"),
    [
        (Column("x", "mm", 2), -0.001, "0.00"),
        (Column("x", "mm", 2), -1.005, "-1.00"),
        (Column("x", "mm", 2), None, "–"),
        (Column("n"), 12, "12"),
        (Column("d"), 1e-7, "1e-07"),
        (Column("id", numeric=False), "0101", "0101"),
    ],
)
def test_cell_text(column: Column, cell: Any, text: str) -> None:
    assert cell_text(column, cell) == text
