"""``splinebba compare``, and what `adjust` writes for CI systems."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Projects a and b of other noise, adjusted; a was not given an acceptable limit."""
    folder = tmp_path_factory.mktemp("compare")
    for name, seed in (("a", 3), ("b", 4)):
        assert run("simulate", "six-image-mixed", "-o", folder / name, "--seed", seed).exit_code == 0
    project = folder / "a" / "project.yaml"
    limits = "\nacceptance:\n  global_test: true\n  max_position_sigma_m: 0.001\n"
    project.write_text(project.read_text(encoding="utf-8") + limits, encoding="utf-8")
    assert run("adjust", folder / "b", "-q", "--no-html").exit_code == 0
    found = run(
        "adjust", folder / "a", "-q", "--no-html", "--format", "github", "--junit", folder / "junit.xml"
    )
    assert found.exit_code == 1
    (folder / "stdout.txt").write_text(found.stdout, encoding="utf-8")
    return folder


def results(folder: Path, name: str) -> Path:
    return folder / name / "project.results"


def test_text(folder: Path) -> None:
    found = run("compare", results(folder, "a"), results(folder, "b"))
    assert found.exit_code == 0, found.output
    for words in ("Relation: independent", "Variances of unit weight", "Images, A − B", "tie-1", "d′C⁻¹d"):
        assert words in found.stdout, words


def test_a_result_is_the_same_as_itself(folder: Path) -> None:
    found = run("compare", results(folder, "a"), results(folder, "a"), "--fail-on-difference")
    assert found.exit_code == 0
    assert found.stdout.startswith("Images and points are the same")


def test_json_and_exit_code(folder: Path) -> None:
    found = run("compare", results(folder, "a"), results(folder, "b"), "--format", "json")
    data = json.loads(found.stdout)
    assert data["format"] == "splinebba-comparison/1"
    assert {item["status"] for item in data["inputs"]} == {"same", "changed"}
    assert len(data["images"]["differences"]) == 6
    strict = run(
        "compare", results(folder, "a"), results(folder, "b"), "--alpha", 0.9999999, "--fail-on-difference"
    )
    assert strict.exit_code == 1
    assert "differ significantly" in strict.stdout


def test_what_is_no_result(folder: Path) -> None:
    found = run("compare", results(folder, "a"), folder, "--format", "json")
    assert found.exit_code == 2
    assert json.loads(found.stdout)["problems"][0]["code"] == "SBB602"
    assert run("compare", results(folder, "a"), results(folder, "b"), "--alpha", 2).exit_code == 2


def test_annotations_and_junit_of_a_missed_criterion(folder: Path) -> None:
    lines = (folder / "stdout.txt").read_text(encoding="utf-8").splitlines()
    assert [
        line for line in lines if line.startswith("::error ") and "title=SBB510" in line and ",line=" in line
    ]
    assert all(line.startswith("::") for line in lines)
    root = ElementTree.fromstring((folder / "junit.xml").read_bytes())
    failed = [case.attrib["name"] for case in root.iter("testcase") if case.find("failure") is not None]
    assert failed == ["max_position_sigma_m"]
    criteria = json.loads((results(folder, "a") / "result.json").read_text(encoding="utf-8"))["acceptance"]
    assert [(each["criterion"], each["status"]) for each in criteria] == [
        ("global_test", "passed"),
        ("max_position_sigma_m", "failed"),
    ]


def test_junit_of_an_invalid_project(tmp_path: Path) -> None:
    project = tmp_path / "project.yaml"
    project.write_text("nonsense: 1\n", encoding="utf-8")
    found = run("adjust", project, "-q", "--format", "github", "--junit", tmp_path / "junit.xml")
    assert found.exit_code == 2
    assert found.stdout.startswith("::error file=")
    root = ElementTree.fromstring((tmp_path / "junit.xml").read_bytes())
    assert len(list(root.iter("error"))) == 1
