"""Sections of acceptance, precision and checks."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.evidence import Criterion
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.blocks import Facts, Table
from splinebba_cli.report.check_sections import acceptance_section, checks_section
from splinebba_cli.report.plan_figure import block_plan
from splinebba_cli.report.precision_section import precision_section
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.output.factory import make_result, write_results


@cache
def result() -> AdjustmentResult:
    return adjust(simulate_block("six-image-mixed", 2)[0])


def data(found: AdjustmentResult) -> ResultData:
    return ResultData(result_to_dict(found))


def test_acceptance_stands_first_and_marks_what_failed() -> None:
    criteria = (
        Criterion("max_sigma0", "σ̂₀", 0.9, 1.2, "", "passed", "fine"),
        Criterion("min_check_points", "number of check points", 6.0, 30.0, "", "failed", "few"),
        Criterion("check_tests", "tests", None, None, "", "untested", "none"),
    )
    report = build_report(data(replace(result(), acceptance=criteria)))
    assert [section.id for section in report.sections[:2]] == ["acceptance", "problems"]
    facts, table = report.sections[0].blocks
    assert isinstance(facts, Facts) and facts.items[0].value == "1 of 3" and facts.items[0].tone == "bad"
    assert isinstance(table, Table) and table.marked == {1, 2}
    assert [row[2] for row in table.rows] == ["≤ 1.2", "≥ 30", "test"]
    assert not acceptance_section(data(result())).blocks


def test_checks_show_accuracies_tests_and_splines() -> None:
    section = checks_section(data(result()))
    labels = {
        fact.label: fact for block in section.blocks if isinstance(block, Facts) for fact in block.items
    }
    assert {
        "RMSE horizontal",
        "3D positional accuracy",
        "Single points",
        "All points together",
    } <= labels.keys()
    assert labels["Single points"].tone == "good"
    tables = [block for block in section.blocks if isinstance(block, Table)]
    assert [table.caption.split(":")[0] for table in tables] == [
        "Check points by coordinate",
        "Check points",
        "Check splines",
    ]


def test_precision_shows_the_worst_first() -> None:
    tables = [block for block in precision_section(data(result())).blocks if isinstance(block, Table)]
    assert [table.caption.split(":")[0] for table in tables[:2]] == ["Perspective centres", "Points"]
    radius = [float(row[-2]) for row in tables[0].rows]  # type: ignore[arg-type]
    assert radius == sorted(radius, reverse=True)
    assert len(tables[1].rows) == 20 and "of 52" in tables[1].note
    assert not precision_section(data(make_result())).blocks


def test_the_plan_draws_ellipses(tmp_path: Path) -> None:
    write_results(tmp_path / "out", result(), html=False)
    with_ellipses = block_plan(ResultData.load(tmp_path / "out"))
    (tmp_path / "out" / "error_ellipses.csv").unlink()
    assert with_ellipses.count("<path") > block_plan(ResultData.load(tmp_path / "out")).count("<path") + 50
