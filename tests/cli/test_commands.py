"""The commands as a user runs them: what they print, their exit codes, the files."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app
from splinebba_cli.project.json_schema import schema_text

runner = CliRunner()


def run(*arguments: object) -> Result:
    return runner.invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A simulated block with control, tie and check features."""
    folder = tmp_path / "block"
    result = run("simulate", "six-image-mixed", "-o", folder, "--seed", 3)
    assert result.exit_code == 0, result.output
    return folder / "project.yaml"


def edited(project: Path, old: str, new: str) -> Path:
    text = project.read_text(encoding="utf-8")
    assert text.count(old) == 1, old
    project.write_text(text.replace(old, new), encoding="utf-8")
    return project


def content(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return found


def test_check_prints_counts_and_budget(project: Path) -> None:
    result = run("check", project)
    assert result.exit_code == 0, result.output
    assert re.search(
        r"6 images, 5 splines with \d+ measured points, \d+ points with \d+ measured points", result.stdout
    )
    assert re.search(r"\d+ equations, \d+ unknowns, rank \d+, nullity 0, redundancy \d+", result.stdout)
    assert list(project.parent.glob("*.results")) == []


def test_check_as_json(project: Path) -> None:
    result = run("check", project, "--format", "json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert set(found) >= {"counts", "budget", "features", "images", "problems"}
    budget = found["budget"]
    assert budget["rank"] + budget["nullity"] == budget["unknowns"]
    assert budget["redundancy"] == budget["equations"] - budget["rank"]
    assert found["counts"]["images"] == len(found["images"]) == 6
    assert found["counts"]["arc_lengths"] == found["counts"]["tangents"] == 0
    for feature in found["features"]:
        parts = ("arc_lengths", "tangents", "given_values", "shape_conditions")
        assert feature["equations"] == 2 * feature["observations"] + sum(feature[key] for key in parts)
        assert feature["unknowns"] == feature["coefficients"] + feature["locations"]
        assert feature["redundancy"] == feature["equations"] - feature["rank"]
    tie = next(feature for feature in found["features"] if feature["id"] == "tie-1")
    assert (tie["lee_unknowns"], tie["coefficients"]) == (12 * 6 + tie["locations"], 21)
    assert "continuity takes the rest" in tie["reason"]
    for image in found["images"]:
        measured = 2 * (image["points"] + image["spline_points"])
        assert image["equations"] == measured + image["arc_lengths"] + image["tangents"] + image["priors"]


def test_check_shows_features_and_images(project: Path) -> None:
    result = run("check", project)
    lines = result.stdout.splitlines()
    assert max(map(len, lines)) <= 110
    found = json.loads(run("check", project, "--format", "json").stdout)
    shown = {line.split()[0]: line.split() for line in lines if line.startswith(" ") and line.split()}
    for feature in found["features"]:
        if feature["kind"] == "spline":
            keys = (
                "images", "observations", "equations", "unknowns", "rank", "redundancy", "orientation_conditions",
                "gauge_conditions", "lee_unknowns", "lee_redundancy",
            )  # fmt: skip
            assert shown[feature["id"]][1:] == [str(feature[key]) for key in keys]
    assert shown["6"][-1] == str(found["images"][5]["redundancy"])
    assert any("natural spline: 3(n+1)" in line for line in lines)


def test_check_of_an_invalid_project(project: Path) -> None:
    edited(project, "role: check", "rolle: check")
    result = run("check", project)
    assert result.exit_code == 2
    assert "error[SBB201]: unknown key `rolle`" in result.stdout
    assert "did you mean `role`?" in result.stdout
    assert re.search(r"\^{5}$", result.stdout, re.MULTILINE)
    as_json = run("check", project, "--format", "json")
    assert as_json.exit_code == 2
    (problem,) = json.loads(as_json.stdout)["problems"]
    assert problem["code"] == "SBB201" and problem["line"] > 1
    github = run("check", project, "--format", "github")
    assert github.exit_code == 2
    assert github.stdout.startswith("::error file=") and "title=SBB201" in github.stdout


def test_adjust_writes_the_results(project: Path) -> None:
    result = run("adjust", project)
    assert result.exit_code == 0, result.output
    folder = project.parent / "project.results"
    names = {path.name for path in folder.iterdir()}
    assert names >= {
        "result.json", "adjusted.yaml", "residuals.csv", "exterior_orientation.csv",
        "spline_coefficients.csv",
        "spline_locations.csv", "points.csv", "dispersion.npz", "report.html", "report.txt",
    }  # fmt: skip
    jsonschema.Draft202012Validator(json.loads(schema_text("result"))).validate(content(folder))
    assert str(folder) in result.stdout
    assert "joint" in result.stderr and "joint" not in result.stdout


def test_adjusting_again_changes_nothing(project: Path, tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    assert run("adjust", project, "-o", first, "--no-html").exit_code == 0
    assert run("adjust", first / "adjusted.yaml", "-o", second, "--no-html").exit_code == 0
    a, b = content(first), content(second)
    for key in ("observations", "unknowns", "conditions", "redundancy"):
        assert a["statistics"][key] == b["statistics"][key]
    assert b["statistics"]["sigma0"] == pytest.approx(a["statistics"]["sigma0"], rel=1e-9)
    for one, other in zip(a["images"], b["images"], strict=True):
        for key in ("x", "y", "z"):
            assert other[key] == pytest.approx(one[key], abs=1e-3 * one["sigma"][key])
    for one, other in zip(a["splines"], b["splines"], strict=True):
        for knot, again in zip(one["knots"], other["knots"], strict=True):
            assert again == pytest.approx(knot, abs=1e-5)  # along the curve only weakly determined
    for one, other in zip(a["points"], b["points"], strict=True):
        assert [other[k] for k in "xyz"] == pytest.approx([one[k] for k in "xyz"], abs=1e-6)


def test_same_input_same_bytes(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    for name in ("a", "b"):
        assert run("adjust", project, "-o", tmp_path / "r", "--no-html", "-q").exit_code == 0
        (tmp_path / "r").rename(tmp_path / name)
    files = sorted(path.name for path in (tmp_path / "a").iterdir())
    differing = [f for f in files if (tmp_path / "a" / f).read_bytes() != (tmp_path / "b" / f).read_bytes()]
    assert differing == []


def test_adjust_options(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = run("adjust", project, "-o", out, "--dispersion", "none", "--no-html", "--format", "json", "-q")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["accepted"] is True and found["status"]["converged"] is True
    assert found["results"] == str(out)
    assert result.stderr == ""
    names = {path.name for path in out.iterdir()}
    assert "dispersion.npz" not in names and "report.html" not in names


def test_acceptance(project: Path, tmp_path: Path) -> None:
    project.write_text(project.read_text() + "acceptance: {max_sigma0: 1e-3, max_check_spline_rms_m: 1000}\n")
    result = run("adjust", project, "-o", tmp_path / "out", "--no-html", "--format", "json")
    assert result.exit_code == 1
    found = json.loads(result.stdout)
    assert not found["accepted"]
    assert [p["subject"] for p in found["problems"] if p["code"] == "SBB510"] == ["acceptance.max_sigma0"]
    assert content(tmp_path / "out")["problems"][0]["code"] == "SBB510"
    report = (tmp_path / "out" / "report.txt").read_text(encoding="utf-8")
    assert "ADJUSTED, BUT NOT ACCEPTABLE" in report
    assert "σ̂₀" in report.partition("SBB510")[2].partition("exceeds")[0]
    as_text = run("adjust", project, "-o", tmp_path / "out", "--no-html", "-q")
    assert as_text.exit_code == 1
    assert as_text.stdout.startswith("Adjusted, but not acceptable")
    assert as_text.stdout.count("SBB510") == 1


def test_nothing_is_written_for_an_invalid_project(project: Path) -> None:
    edited(project, "role: check", "rolle: check")
    result = run("adjust", project)
    assert result.exit_code == 2
    assert "SBB201" in result.stderr and result.stdout == ""
    assert list(project.parent.glob("*.results*")) == []


def test_singular_network(tmp_path: Path) -> None:
    folder = tmp_path / "block"
    assert run("simulate", "six-image-singular", "-o", folder).exit_code == 0
    result = run("adjust", folder)
    assert result.exit_code == 3, result.output
    assert "error[SBB5" in result.stderr and "help:" in result.stderr
    assert list(folder.glob("*.results*")) == []
    as_json = run("adjust", folder, "--format", "json")
    assert as_json.exit_code == 3
    assert all(problem["code"].startswith("SBB5") for problem in json.loads(as_json.stdout)["problems"])


def test_old_results_survive_a_failure(project: Path) -> None:
    assert run("adjust", project, "--no-html").exit_code == 0
    folder = project.parent / "project.results"
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    edited(project, "role: check", "rolle: check")
    assert run("adjust", project).exit_code == 2
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_an_unexpected_error_is_logged(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("a secret of the program")

    monkeypatch.setattr("splinebba_cli.core.adjustment.adjust", broken)
    result = run("adjust", project)
    assert result.exit_code == 70
    assert "Traceback" not in result.output
    log = re.search(r"the details are in (\S+)", result.stderr)
    assert log is not None
    text = Path(log.group(1)).read_text(encoding="utf-8")
    assert "Traceback" in text and "a secret of the program" in text
    Path(log.group(1)).unlink()


def test_report(project: Path, tmp_path: Path) -> None:
    assert run("adjust", project, "-o", tmp_path / "out", "--no-html").exit_code == 0
    result = run("report", tmp_path / "out", "--format", "text", "-o", tmp_path / "r.txt")
    assert result.exit_code == 0, result.output
    assert result.stdout.strip() == str(tmp_path / "r.txt")
    assert (tmp_path / "r.txt").read_text(encoding="utf-8").strip()
    nothing = run("report", project.parent)
    assert nothing.exit_code == 2
    assert "SBB602" in nothing.stderr


def test_simulate(tmp_path: Path) -> None:
    listed = run("simulate", "list")
    assert "six-image" in listed.stdout.split()
    unknown = run("simulate", "six-imag", "-o", tmp_path / "x")
    assert unknown.exit_code == 2 and "did you mean `six-image`?" in unknown.stderr
    assert run("simulate", "strip", "-o", tmp_path / "x").exit_code == 0
    again = run("simulate", "strip", "-o", tmp_path / "x")
    assert again.exit_code == 2 and "SBB603" in again.stderr
    assert run("simulate", "strip", "-o", tmp_path / "x", "--force").exit_code == 0


@pytest.mark.parametrize("which", ["project", "result", "campaign"])
def test_schema(which: str) -> None:
    assert json.loads(run("schema", which).stdout)["$id"].endswith(f"/{which}.schema.json")


def test_explain() -> None:
    assert "reference to an unknown id" in run("explain", "sbb301").stdout
    assert len(run("explain").stdout.splitlines()) > 50
    assert run("explain", "SBB000").exit_code == 2


def test_usage_errors() -> None:
    assert run("adjust").exit_code == 2
    assert run("adjust", "x.yaml", "--tables", "xlsx").exit_code == 2
    assert run("fly").exit_code == 2
    assert run("--version").stdout.startswith("splinebba 0.")
