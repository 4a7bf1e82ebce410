"""``splinebba init`` as a user runs it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.commands.init import TemplateChoice
from splinebba_cli.starters.catalogue import TEMPLATES

RUNNER = CliRunner()


def init(*arguments: str, expected: int = 0) -> str:
    result = RUNNER.invoke(app, ["init", *arguments])
    assert result.exit_code == expected, result.output
    return result.output


def test_choices_are_the_templates() -> None:
    assert [choice.value for choice in TemplateChoice] == list(TEMPLATES)


def test_list() -> None:
    assert [line.split()[0] for line in init("--list").splitlines()] == list(TEMPLATES)
    assert [t["name"] for t in json.loads(init("--list", "--format", "json"))["templates"]] == list(TEMPLATES)


def test_writes_a_project_and_says_what_next(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    told = init()
    assert "splinebba adjust aerial" in told
    assert os.listdir(tmp_path) == ["aerial"]
    assert RUNNER.invoke(app, ["check", "aerial"]).exit_code == 0


def test_json(tmp_path: Path) -> None:
    data = json.loads(init(str(tmp_path / "a b"), "-t", "close-range", "--format", "json"))
    assert data["files"] == sorted(os.listdir(tmp_path / "a b"))
    assert data["next"][1] == f"splinebba adjust '{tmp_path / 'a b'}'"


def test_an_empty_folder_keeps_its_place(tmp_path: Path) -> None:
    """A shell that stands in it still does afterwards."""
    (tmp_path / "new").mkdir()
    before = (tmp_path / "new").stat().st_ino
    init(str(tmp_path / "new"))
    assert (tmp_path / "new").stat().st_ino == before
    assert (tmp_path / "new" / "project.yaml").exists()


def test_never_overwrites_unasked(tmp_path: Path) -> None:
    own = tmp_path / "project.yaml"
    own.write_text("mine", encoding="utf-8")
    (tmp_path / "notes.txt").write_text("mine too", encoding="utf-8")
    assert "SBB603" in init(str(tmp_path), expected=2)
    assert own.read_text(encoding="utf-8") == "mine"
    assert sorted(os.listdir(tmp_path)) == ["notes.txt", "project.yaml"]
    init(str(tmp_path), "--force")
    assert own.read_text(encoding="utf-8") != "mine"
    assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine too"


def test_a_file_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("mine", encoding="utf-8")
    assert "is a file" in init(str(tmp_path / "x"), "--force", expected=2)


def test_nothing_is_left_of_a_refusal(tmp_path: Path) -> None:
    line = tmp_path / "line.csv"
    line.write_text(
        "x,y,z\n" + "".join(f"{5000 + k},{7000 + k},3\n" for k in range(0, 900, 50)), encoding="utf-8"
    )
    assert "SBB821" in init(str(tmp_path / "new"), "--polyline", str(line), expected=2)
    assert os.listdir(tmp_path) == ["line.csv"]


def test_heights_that_are_missing_can_be_given(tmp_path: Path) -> None:
    """The cure that the message names is an option of this command, too."""
    path = tmp_path / "lines.geojson"
    rows = [[5000.0 + 25 * k, 7000.0 + 90 * ((k // 4) % 2)] for k in range(40)]
    path.write_text(json.dumps({"type": "LineString", "coordinates": rows}), encoding="utf-8")
    told = init(str(tmp_path / "new"), "--polyline", str(path), expected=2)
    assert "SBB322" in told and "--z METRES" in told
    init(str(tmp_path / "new"), "--polyline", str(path), "--z", "0", "--threshold-m", "5")


def test_a_polyline_belongs_to_one_template(tmp_path: Path) -> None:
    told = init(str(tmp_path / "new"), "-t", "aerial", "--polyline", "lines.csv", expected=2)
    assert "control-splines" in told
    assert os.listdir(tmp_path) == []
