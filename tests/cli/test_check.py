"""``splinebba check`` beside its counts: what it says of projects that are not ready."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app

runner = CliRunner()


@pytest.fixture
def without_orientation(tmp_path: Path) -> Path:
    """A project that knows nothing of its images, with too few control points in them: no budget."""
    made = runner.invoke(app, ["init", str(tmp_path / "block")])
    assert made.exit_code == 0, made.output
    images = tmp_path / "block" / "images.csv"
    text = images.read_text(encoding="utf-8")
    images.write_text(re.sub(r"^(\d+),.*$", r"\1" + "," * 6, text, flags=re.MULTILINE), encoding="utf-8")
    project = tmp_path / "block" / "project.yaml"
    text = project.read_text(encoding="utf-8")
    project.write_text(re.sub(r"\n  sigma: \{x: .*", "", text), encoding="utf-8")
    return project


def test_warnings_are_told_where_there_is_no_budget(without_orientation: Path) -> None:
    result = runner.invoke(app, ["check", str(without_orientation)])
    assert result.exit_code == 3, result.output
    assert "warning[SBB315]" in result.stdout
    assert "error[SBB503]" in result.stderr
    quiet = runner.invoke(app, ["check", str(without_orientation), "-q"])
    assert (quiet.exit_code, quiet.stdout) == (3, "")


def test_warnings_where_there_is_no_budget_as_json(without_orientation: Path) -> None:
    result = runner.invoke(app, ["check", str(without_orientation), "--format", "json"])
    assert result.exit_code == 3
    assert {each["code"] for each in json.loads(result.stdout)["problems"]} == {"SBB315", "SBB503"}


def test_annotations_where_there_is_no_budget(without_orientation: Path) -> None:
    result = runner.invoke(app, ["check", str(without_orientation), "--format", "github"])
    assert result.exit_code == 3
    assert {line.split()[0] for line in result.stdout.splitlines() if line} == {"::warning", "::error"}


def test_the_phase_of_a_circle_is_no_defect(tmp_path: Path) -> None:
    """Nobody sees where a circle begins; what its shape lacks would still be an error."""
    made = runner.invoke(app, ["init", str(tmp_path / "object"), "--template", "close-range"])
    assert made.exit_code == 0, made.output
    result = runner.invoke(app, ["check", str(tmp_path / "object"), "--format", "json"])
    assert result.exit_code == 0, result.output
    problems = json.loads(result.stdout)["problems"]
    assert [(each["code"], each["severity"]) for each in problems] == [("SBB520", "info")]
    assert "phase of u" in problems[0]["message"]
