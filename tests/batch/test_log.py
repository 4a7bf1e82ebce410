"""The log of a batch can be read while the batch runs, and after it was killed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from splinebba_cli.batch.log import LOG_FORMAT, BatchLog
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.errors import OutputError


def test_every_line_is_there_at_once(tmp_path: Path) -> None:
    path = tmp_path / "batch.jsonl"
    log = BatchLog(path, {"projects": 2})
    outcome = Outcome("σ.yaml", Verdict.killed)
    log.add(outcome)
    head, line = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    assert (head["format"], head["projects"]) == (LOG_FORMAT, 2)
    assert Outcome.of_data(line) == outcome and line["finished"].endswith("Z")
    log.close({"not_run": 1})
    assert json.loads(path.read_text(encoding="utf-8").splitlines()[-1])["not_run"] == 1


def test_a_name_that_is_no_unicode(tmp_path: Path) -> None:
    log = BatchLog(tmp_path / "batch.jsonl", {})
    log.add(outcome := Outcome("caf\udce9.yaml", Verdict.accepted))
    log.close({})
    line = (tmp_path / "batch.jsonl").read_text(encoding="utf-8").splitlines()[1]
    assert Outcome.of_data(json.loads(line)) == outcome


def test_a_place_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="SBB607"):
        BatchLog(tmp_path, {})
