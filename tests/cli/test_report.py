"""The command `report`: formats, files and standard output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app
from tests.output.factory import make_result, write_results


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report") / "out"
    write_results(folder, make_result(splines=2), html=False)
    return folder


@pytest.mark.parametrize(
    ("format", "name"),
    [("html", "report.html"), ("text", "report.txt"), ("markdown", "report.md")],
)
def test_file_and_standard_output_have_the_same_bytes(results: Path, format: str, name: str) -> None:
    result = run("report", results, "--format", format)
    assert result.exit_code == 0, result.output
    assert result.stdout.strip() == str(results / name)
    piped = run("report", results, "--format", format, "-o", "-")
    assert piped.stdout_bytes == (results / name).read_bytes()
    assert piped.stderr == ""


def test_json_goes_to_standard_output_unless_a_file_is_named(results: Path, tmp_path: Path) -> None:
    piped = run("report", results, "--format", "json")
    assert json.loads(piped.stdout)["format"] == "splinebba-report/1"
    file = tmp_path / "report.json"
    told = json.loads(run("report", results, "--format", "json", "-o", file).stdout)
    assert told == {"report": str(file), "problems": []}
    assert file.read_bytes() == piped.stdout_bytes
    nothing = run("report", tmp_path, "--format", "json")
    assert nothing.exit_code == 2
    assert json.loads(nothing.stdout)["problems"][0]["code"] == "SBB602"


def test_no_browser_is_said(results: Path) -> None:
    result = run("report", results, "--format", "pdf", "--browser", "no-such-browser")
    assert result.exit_code == 2
    assert "error[SBB620]: no program `no-such-browser` was found" in result.stderr
    assert "help: " in result.stderr
    assert not (results / "report.pdf").exists()
