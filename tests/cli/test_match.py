"""`splinebba match` as a user runs it: what it prints, its exit codes, and what can be done with what it writes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import NotSolvableError
from splinebba_cli.project.loading import load_project
from tests.labelled_chains import LOST, known_matching, street


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return street(tmp_path_factory.mktemp("street"))


@pytest.fixture
def project(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A street in a folder of its own, and a matching that knows the truth."""
    shutil.copytree(original.parent, tmp_path / "street")
    path = tmp_path / "street" / "project.yaml"
    found = known_matching(load_project(path, "matching"))
    monkeypatch.setattr("splinebba_cli.core.matching.match.match", lambda *_, **__: found)
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_summary_folder_and_next_step(project: Path) -> None:
    result = run("match", project)
    assert result.exit_code == 0, result.output
    folder = project.with_name("project.matched")
    assert (folder / "match.html").exists()
    lines = result.stdout.splitlines()
    assert lines[0] == "Matched, but not in every image"
    assert f"Results: {folder}" in lines and f"Next: splinebba adjust {folder / 'matched.yaml'}" in lines
    rows = [line.split() for line in lines if line.startswith(f" {LOST} ")]
    assert rows[0][2] == "0" and "left" in rows[0]


def test_the_matched_project_is_adjusted(project: Path) -> None:
    assert run("match", project, "-q", "--no-html").exit_code == 0
    matched = project.with_name("project.matched") / "matched.yaml"
    assert run("check", matched).exit_code == 0
    result = run("adjust", matched, "--no-html", "-q", "--format", "json")
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert content["statistics"]["global_test"]["passed"] and content["status"]["converged"]


def test_json(project: Path) -> None:
    content = json.loads(run("match", project, "--format", "json", "-q").stdout)
    assert content["project"].endswith("project.matched/matched.yaml") and content["accepted"] is True
    assert content["counts"]["matched"] + sum(content["reasons"].values()) == content["counts"]["points"]
    assert [problem["code"] for problem in content["problems"]] == ["SBB534"]


def test_a_share_that_is_too_small_ends_with_1_and_is_written(project: Path) -> None:
    with project.open("a", encoding="utf-8") as stream:
        stream.write("\n")
    text = project.read_text(encoding="utf-8").replace("new_curves: true", "min_matched_share: 0.9")
    project.write_text(text, encoding="utf-8")
    result = run("match", project, "--no-html")
    assert result.exit_code == 1 and result.stdout.startswith("Matched, but not accepted")
    assert project.with_name("project.matched").is_dir()


def test_an_orientation_that_is_not_determined_ends_with_3(
    project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def undetermined(*_: Any, **__: Any) -> None:
        raise NotSolvableError(
            [Problem("SBB522", "error", "ω and Y₀ are not separable", "image `1`", "control")]
        )

    monkeypatch.setattr("splinebba_cli.core.matching.match.match", undetermined)
    result = run("match", project)
    assert result.exit_code == 3 and "error[SBB522]" in result.stderr
    assert not project.with_name("project.matched").exists()


def test_what_goes_on_is_told_on_stderr(project: Path) -> None:
    result = run("match", project, "-v")
    assert f"writing {project.with_name('project.matched')}" in result.stderr
    assert "time: read" in result.stderr and "match" in result.stderr
