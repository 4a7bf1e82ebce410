"""The file of finished runs: continued where the campaign is the same, refused where it is not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from splinebba_cli.errors import OutputError, SimulationError
from splinebba_cli.output.run_log import RUNS_FILE, RunLog, discard_runs
from splinebba_cli.simulation.run_record import Failure, failed_record

IDENTITY: dict[str, Any] = {
    "target": "block",
    "inputs": {"project.yaml": "abc", "knots.csv": "def"},
    "options": {"seed": 1, "noise": {"image_mm": 0.005}},
}


def written(folder: Path, runs: list[int]) -> None:
    log = RunLog(folder, IDENTITY, resume=False)
    for run in runs:
        log.append(failed_record(run, Failure("SBB502", "no")))
    log.close()


def test_finished_runs_are_there_at_once(tmp_path: Path) -> None:
    log = RunLog(tmp_path / "new", IDENTITY, resume=False)
    log.append(failed_record(4, Failure("SBB502", "no")))
    text = (tmp_path / "new" / RUNS_FILE).read_text(encoding="utf-8")
    assert text.count("\n") == 2 and text.endswith("\n")
    log.close()


def test_a_campaign_continues(tmp_path: Path) -> None:
    written(tmp_path, [0, 2])
    log = RunLog(tmp_path, IDENTITY, resume=True)
    assert log.finished == {0, 2}
    log.append(failed_record(1, Failure("SBB522", "else")))
    log.close()
    again = RunLog(tmp_path, IDENTITY, resume=True)
    assert [record.run for record in again.records(3)] == [0, 1, 2]
    assert [record.run for record in again.records(2)] == [0, 1]
    again.close()


def test_a_line_that_was_cut_off_is_run_again(tmp_path: Path) -> None:
    written(tmp_path, [0, 1])
    path = tmp_path / RUNS_FILE
    path.write_bytes(path.read_bytes()[:-20])
    log = RunLog(tmp_path, IDENTITY, resume=True)
    assert log.finished == {0}
    log.append(failed_record(1, Failure("SBB502", "no")))
    log.close()
    again = RunLog(tmp_path, IDENTITY, resume=True)
    assert again.finished == {0, 1}
    again.close()


def test_runs_are_not_overwritten(tmp_path: Path) -> None:
    written(tmp_path, [0])
    with pytest.raises(OutputError, match="holds a campaign already") as refused:
        RunLog(tmp_path, IDENTITY, resume=False)
    assert refused.value.code == "SBB603"
    discard_runs(tmp_path)
    RunLog(tmp_path, IDENTITY, resume=False).close()


@pytest.mark.parametrize(
    ("part", "change", "named"),
    [
        ("inputs", {"knots.csv": "xyz"}, "inputs `knots.csv`"),
        ("inputs", {"truth.json": "new"}, "inputs `truth.json`"),
        ("options", {"seed": 2}, "options `seed`"),
        ("options", {"noise": {"image_mm": 0.006}}, "options `noise`"),
    ],
)
def test_another_campaign_is_refused(part: str, change: dict[str, Any], named: str, tmp_path: Path) -> None:
    written(tmp_path, [0])
    before = (tmp_path / RUNS_FILE).read_bytes()
    with pytest.raises(SimulationError, match=named) as refused:
        RunLog(tmp_path, {**IDENTITY, part: {**IDENTITY[part], **change}}, resume=True)
    assert refused.value.code == "SBB703"
    assert (tmp_path / RUNS_FILE).read_bytes() == before


def test_a_foreign_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / RUNS_FILE).write_text("something else\n", encoding="utf-8")
    with pytest.raises(SimulationError, match="no JSON"):
        RunLog(tmp_path, IDENTITY, resume=True)
