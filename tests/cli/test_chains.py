"""``splinebba chains`` as a user runs it: files, summary, JSON, refusals, and a project that reads its table."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from splinebba_cli import load_project
from splinebba_cli.commands.app import app

SAMPLE = Path(__file__).parents[2] / "sample_projects" / "edge_chains"
SEGMENTS = "1 2 30 40 2.0 0.1 9\n5 6 70 8 2.0 0.1 9\n"


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def segments(tmp_path: Path) -> Path:
    path = tmp_path / "1.txt"
    path.write_text(SEGMENTS, encoding="utf-8")
    return path


def test_summary_and_table(segments: Path) -> None:
    target = segments.with_name("chains.csv")
    result = run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", target)
    assert result.exit_code == 0, result.output
    assert "table: chains.csv" in result.stdout and "reading 1 file" in result.stderr
    assert target.read_text(encoding="utf-8").splitlines()[:2] == ["image,chain,x,y", "1,1,1.0,2.0"]
    again = run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", target)
    assert again.exit_code == 2 and "SBB603" in again.stderr
    assert run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", target, "--force").exit_code == 0


def test_stdout_has_the_table_alone(segments: Path) -> None:
    result = run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", "-")
    assert result.stdout.splitlines()[0] == "image,chain,x,y" and len(result.stdout.splitlines()) == 5
    assert "Points left out" in result.stderr


def test_json(segments: Path) -> None:
    target = segments.with_name("chains.csv")
    result = run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", target, "--format", "json")
    found = json.loads(result.stdout)
    assert found["output"] == str(target) and found["problems"] == []
    assert found["images"] == [{"image": "1", "chains_read": 2, "points_read": 4, "chains": 2, "points": 4}]
    refused = run("chains", segments, "-o", target, "--force", "--format", "json")
    assert refused.exit_code == 2
    assert [problem["code"] for problem in json.loads(refused.stdout)["problems"]] == ["SBB402"]


@pytest.mark.parametrize(
    "words", [["--columns", "x1,z1"], ["--spacing", "0"], ["--spacing", "nan"], ["--y-up", "inf"]]
)
def test_usage(segments: Path, words: list[str]) -> None:
    target = segments.with_name("chains.csv")
    result = run("chains", segments, "-o", target, *words)
    assert result.exit_code == 2 and "SBB900" in result.stderr and not target.exists()


def test_a_project_reads_the_table(tmp_path: Path, segments: Path) -> None:
    project = shutil.copytree(SAMPLE, tmp_path / "street")
    result = run("chains", segments, "--columns", "x1,y1,x2,y2", "-o", project / "chains.csv", "--force")
    assert result.exit_code == 0
    points = load_project(project, "matching").network.unlabelled
    assert points.chain_ids == ("1/1", "1/2") and points.photo_xy.tolist() == [
        [1, 2],
        [30, 40],
        [5, 6],
        [70, 8],
    ]
