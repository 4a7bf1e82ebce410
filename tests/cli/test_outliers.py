"""Outliers from the command line to the files and the report."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app
from splinebba_cli.project.json_schema import schema_text

runner = CliRunner()
BLUNDER_LINE = 41  # of spline_observations.csv, the header is 0


def run(*arguments: object) -> Result:
    return runner.invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated block with one gross error of 0.2 mm, 40 σ."""
    folder = tmp_path_factory.mktemp("outliers") / "block"
    assert run("simulate", "six-image-mixed", "-o", folder, "--seed", 3).exit_code == 0
    table = folder / "spline_observations.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    cells = lines[BLUNDER_LINE].split(",")
    cells[2:4] = [str(float(value) + 0.2) for value in cells[2:4]]
    lines[BLUNDER_LINE] = ",".join(cells)
    table.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "project.yaml"


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def content(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return found


def test_snooping_is_told_everywhere(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = run("adjust", project, "-o", out, "--outliers", "snooping")
    assert result.exit_code in (0, 1), result.output
    assert "SBB540" in result.output
    found = content(out)
    jsonschema.validate(found, json.loads(schema_text("result")))
    revision = found["revision"]
    first = revision["rejections"][0]
    assert (first["kind"], first["row"], first["returned"]) == ("spline", BLUNDER_LINE, False)
    assert revision["used"] + revision["rejected"] == 784
    log = rows_of(out / "rejections.csv")
    assert (log[0]["kind"], log[0]["row"], log[0]["round"]) == ("spline", str(BLUNDER_LINE), "1")
    residuals = rows_of(out / "residuals.csv")
    status = [row["status"] for row in residuals]
    assert status.count("rejected") == revision["rejected"]
    assert {row["weight"] for row in residuals if row["status"] == "rejected"} == {"0"}
    splines = [row for row in residuals if row["kind"] == "spline"]
    assert splines[BLUNDER_LINE - 1]["status"] == "rejected"
    assert abs(float(splines[BLUNDER_LINE - 1]["standardized_across"])) > 10.0
    assert found["residuals"]["kinds"][1]["n"] == 660 - sum(row["kind"] == "spline" for row in log)
    assert found["residuals"]["kinds"][1]["max_mm"] < 0.05  # the error is no residual of the adjustment
    tested = {kind["kind"]: kind for kind in found["tests"]["kinds"]}["splines, across"]
    assert tested["n"] == found["residuals"]["kinds"][1]["n"] and tested["largest"] < 3.3
    text = (out / "report.txt").read_text(encoding="utf-8")
    assert "iterative data snooping" in text and first["name"].replace("`", "") in text
    html = (out / "report.html").read_text(encoding="utf-8")
    assert 'id="outliers"' in html


def test_reweighting_says_how_to_read_its_sigma0(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run("adjust", project, "-o", out, "--outliers", "huber", "--no-html")
    residuals = rows_of(out / "residuals.csv")
    assert {row["status"] for row in residuals} == {"used", "reweighted"}
    assert content(out)["revision"]["reweighted"] > 20
    assert "no test of the model" in (out / "report.txt").read_text(encoding="utf-8").replace("\n", " ")


def test_small_sigma0_of_reduced_weights_is_no_failure(project: Path, tmp_path: Path) -> None:
    """Tukey's weights take a tenth of σ̂₀ away: that says nothing about the declared σ."""
    out = tmp_path / "out"
    result = run("adjust", project, "-o", out, "--outliers", "tukey", "--no-html")
    found = content(out)
    test = found["statistics"]["global_test"]
    assert test["statistic"] < test["lower"]
    assert "as reduced weights make it" in " ".join(result.output.split())
    assert "global test" not in result.output and "state a smaller" not in result.output
    assert not {"SBB531", "SBB545"} & {problem["code"] for problem in found["problems"]}


def test_without_a_search_nothing_is_said(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run("adjust", project, "-o", out, "--no-html")
    assert content(out)["revision"]["method"] == "none"
    assert not (out / "rejections.csv").exists()
    assert "\nOutliers\n" not in (out / "report.txt").read_text(encoding="utf-8")


def test_rejections_of_an_old_run_do_not_stay(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    run("adjust", project, "-o", out, "--outliers", "snooping", "--no-html")
    assert (out / "rejections.csv").exists()
    run("adjust", project, "-o", out, "--no-html")
    assert not (out / "rejections.csv").exists()


def test_an_unknown_method_is_refused(project: Path) -> None:
    result = run("adjust", project, "--outliers", "wish")
    assert result.exit_code == 2
