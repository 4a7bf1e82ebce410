"""``splinebba simulate`` of projects, campaigns and predictions, as a user runs it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from typer.testing import CliRunner, Result

from splinebba_cli.commands.app import app
from splinebba_cli.project.json_schema import schema_text
from splinebba_cli.report.campaign_tables import study_table
from tests.regenerate_expected import FOLDER

STARTS = ("--start-position", 3, "--start-angle", 1, "--start-knots", 1.5)


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["simulate", *(str(argument) for argument in arguments)])


def content(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "project"
    shutil.copytree(
        FOLDER / "six_image_mixed", folder, ignore=shutil.ignore_patterns("expected", "*.results")
    )
    return folder


def test_a_project_is_measured_anew(project: Path) -> None:
    result = run(project, "--seed", 5, "--blunders", 0.02)
    assert result.exit_code == 0, result.output
    folder = project / "project.simulated"
    assert result.stdout.strip() == str(folder / "project.yaml")
    truth, old = content(folder / "truth.json"), content(project / "truth.json")
    assert [image["id"] for image in truth["images"]] == [image["id"] for image in old["images"]]
    assert truth["locations"] == pytest.approx(old["locations"])
    text = (folder / "project.yaml").read_text(encoding="utf-8")
    assert "blunder_share: 0.02" in text and "seed: 5" in text
    assert "max_check_rmse_m" in text  # its acceptance is kept
    adjusted = CliRunner().invoke(app, ["check", str(folder)])
    assert adjusted.exit_code == 0, adjusted.output
    again = run(project, "--seed", 5)
    assert again.exit_code == 2 and "SBB603" in again.stderr


def test_a_simulated_project_is_simulated_again(project: Path, tmp_path: Path) -> None:
    """Its truth is the same: only errors differ."""
    assert run(project, "-o", tmp_path / "a", "--seed", 2).exit_code == 0
    assert run(tmp_path / "a", "-o", tmp_path / "b", "--seed", 3).exit_code == 0
    a, b = content(tmp_path / "a" / "truth.json"), content(tmp_path / "b" / "truth.json")
    for key in ("images", "splines", "points"):
        for one, other in zip(a[key], b[key], strict=True):
            for name, value in one.items():
                if isinstance(value, float):
                    assert other[name] == pytest.approx(value, abs=1e-9)
                elif name == "values":
                    assert [x for row in other[name] for x in row] == pytest.approx(
                        [x for row in value for x in row], abs=1e-9
                    )
    tables = [(tmp_path / f / "spline_observations.csv").read_text(encoding="utf-8") for f in "ab"]
    assert tables[0] != tables[1]


def test_a_campaign_and_its_figures(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    result = run(project, "--runs", 3, "--jobs", 1, "-o", out, *STARTS)
    assert result.exit_code == 0, result.output
    assert "share of accepted global tests" in result.stdout and "3 runs, 3 solved" in result.stdout
    assert result.stderr.splitlines()[-3:] == ["1 of 3 runs", "2 of 3 runs", "3 of 3 runs"]
    names = {path.name for path in out.iterdir()}
    figures = {"coverage.svg", "ratios.svg", "normalized_errors.svg", "global_test.svg"}
    assert names == {"runs.jsonl", "campaign.json", *figures}
    found = content(out / "campaign.json")
    jsonschema.Draft202012Validator(json.loads(schema_text("campaign"))).validate(found)
    assert found["runs"] == {"asked": 3, "finished": 3, "solved": 3, "failed": 0, "reasons": []}
    assert set(found["inputs"]) >= {"project.yaml", "truth.json", "spline_observations.csv"}
    statistics = found["statistics"]
    assert sum(statistics["histogram"]["eop"]) == 3 * 36
    assert [image["id"] for image in statistics["images"]] == ["1", "2", "3", "4", "5", "6"]
    assert [s["id"] for s in statistics["splines"]] == ["partial-1", "tie-1", "tie-2", "lake", "check-1"]
    assert statistics["kinds"]["locations"] is None  # no spline whose every value is given


def test_locations_on_given_splines_are_counted(tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    result = run("six-image", "--runs", 3, "--jobs", 1, "-o", out)
    assert result.exit_code == 0, result.output
    assert "coverage of 95 % intervals, locations along" in result.stdout
    assert "Locations along given splines" in result.stdout
    found = content(out / "campaign.json")
    jsonschema.Draft202012Validator(json.loads(schema_text("campaign"))).validate(found)
    statistics = found["statistics"]
    given = {s["id"]: s["locations"]["elements"] for s in statistics["splines"] if s["locations"]}
    assert given == {"control-1": 180, "control-2": 180}  # of tie splines they depend on the datum
    assert statistics["kinds"]["locations"]["elements"] == 360
    assert sum(statistics["histogram"]["locations"]) == 3 * 360
    assert "locations along" in (out / "coverage.svg").read_text(encoding="utf-8")


def test_an_interrupted_campaign_continues_to_the_same_result(project: Path, tmp_path: Path) -> None:
    """Two runs and two more are the same bytes as four at once, in other processes."""
    once, twice = tmp_path / "once", tmp_path / "twice"
    rest = ("--figures", "none", "-q", *STARTS)
    assert run(project, "--runs", 4, "--jobs", 2, "-o", once, *rest).exit_code == 0
    assert run(project, "--runs", 2, "--jobs", 1, "-o", twice, *rest).exit_code == 0
    refused = run(project, "--runs", 4, "-o", twice, *rest)
    assert refused.exit_code == 2 and "SBB603" in refused.stderr and "--resume" in refused.stderr
    assert run(project, "--runs", 4, "--jobs", 1, "--resume", "-o", twice, *rest).exit_code == 0
    assert (once / "campaign.json").read_bytes() == (twice / "campaign.json").read_bytes()
    assert sorted((once / "runs.jsonl").read_text(encoding="utf-8").splitlines()) == sorted(
        (twice / "runs.jsonl").read_text(encoding="utf-8").splitlines()
    )


def test_a_changed_campaign_is_not_continued(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    rest = ("--jobs", 1, "-o", out, "--figures", "none", "-q")
    assert run(project, "--runs", 2, *rest).exit_code == 0
    before = (out / "runs.jsonl").read_bytes()
    other_seed = run(project, "--runs", 3, "--seed", 9, "--resume", *rest)
    assert other_seed.exit_code == 2
    assert "SBB703" in other_seed.stderr and "options `seed`" in other_seed.stderr
    table = project / "points.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("0.02", "0.03"), encoding="utf-8")
    changed = run(project, "--runs", 3, "--resume", *rest)
    assert changed.exit_code == 2 and "inputs `points.csv`" in changed.stderr
    assert (out / "runs.jsonl").read_bytes() == before
    assert run(project, "--runs", 2, "--force", *rest).exit_code == 0


def test_ctrl_c_keeps_what_is_finished(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from splinebba_cli.simulation.campaign import Campaign

    run_of = Campaign.__call__

    def interrupted(self: Campaign, number: int) -> Any:
        if number == 1:
            raise KeyboardInterrupt
        return run_of(self, number)

    out = tmp_path / "campaign"
    monkeypatch.setattr(Campaign, "__call__", interrupted)
    result = run(project, "--runs", 3, "--jobs", 1, "-o", out)
    assert result.exit_code == 130
    assert "1 of 3 runs are kept, --resume continues" in result.stderr
    monkeypatch.undo()
    assert run(project, "--runs", 3, "--jobs", 1, "-o", out, "--resume", "-q").exit_code == 0
    assert content(out / "campaign.json")["runs"]["solved"] == 3


def test_a_convergence_study(tmp_path: Path) -> None:
    out = tmp_path / "study"
    result = run("six-image-mixed", "--runs", 2, "--jobs", 1, "--study", "1,0", "-o", out, "--figures", "png")
    assert result.exit_code == 0, result.output
    assert "Convergence from wrong starts" in result.stdout
    study = content(out / "campaign.json")["study"]
    assert [each["factor"] for each in study] == [0.0, 1.0]
    assert study[0]["same"]["value"] == 1.0
    assert (study[1]["position_m"], study[1]["angle_deg"], study[1]["knots_m"]) == (3.0, 1.0, 1.5)
    assert (out / "convergence.png").read_bytes().startswith(b"\x89PNG")
    assert study_table(study).rows[0][:6] == (0.0, 0.0, 0.0, 0.0, 2, 100.0)


def test_a_campaign_without_any_solution(tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    result = run("six-image-singular", "--runs", 2, "--jobs", 1, "-o", out)
    assert result.exit_code == 3
    assert "2 without a solution: SBB522, orientation not determined" in result.stdout
    found = content(out / "campaign.json")
    jsonschema.Draft202012Validator(json.loads(schema_text("campaign"))).validate(found)
    assert found["statistics"] is None and found["runs"]["reasons"][0]["count"] == 2


def test_prediction(project: Path, tmp_path: Path) -> None:
    out = tmp_path / "prediction"
    result = run(project, "--predict", "-o", out)
    assert result.exit_code == 0, result.output
    assert "predicted standard deviations" in result.stdout and "Redundancy numbers" in result.stdout
    assert {path.name for path in out.iterdir()} == {
        "prediction.json", "exterior_orientation.csv", "points.csv", "spline_coefficients.csv",
        "spline_samples.csv",
    }  # fmt: skip
    found = content(out / "prediction.json")
    assert found["format"] == "splinebba-prediction/1"
    expected = content(FOLDER / "six_image_mixed" / "expected" / "result.json")
    for image, other in zip(found["images"], expected["images"], strict=True):
        for key, sigma in other["sigma"].items():  # of one noisy adjustment, scaled by its σ̂₀ of about 1
            assert image["sigma"][key] == pytest.approx(sigma, rel=0.15)
    as_json = run(project, "--predict", "-o", out, "--format", "json")
    assert json.loads(as_json.stdout)["statistics"]["redundancy"] == 637
    refused = run(project, "--predict", "-o", project)
    assert refused.exit_code == 2 and "SBB602" in refused.stderr


def test_prediction_of_what_is_not_determined() -> None:
    result = run(FOLDER / "table_5_7_one_control_segment", "--predict")
    assert result.exit_code == 3
    assert result.stderr.count("error[SBB522]: image `") == 6


def test_prediction_of_a_flight(project: Path, tmp_path: Path) -> None:
    """Without observations they are placed; what too few images would see is named."""
    text = (project / "project.yaml").read_text(encoding="utf-8")
    text = text[: text.index("observations:")] + text[text.index("adjustment:") :]
    (project / "project.yaml").write_text(text, encoding="utf-8")
    points = project / "points.csv"
    truth = content(project / "truth.json")
    truth["points"].append({"id": "far", "x": 9000.0, "y": 9000.0, "z": 30.0})
    (project / "truth.json").write_text(json.dumps(truth), encoding="utf-8")
    points.write_text(points.read_text(encoding="utf-8") + "far,tie,,,,,,\n", encoding="utf-8")
    result = run(project, "--predict", "-o", tmp_path / "p")
    assert result.exit_code == 0, result.output
    assert "left out, seen by too few images: tie point `far`" in result.stdout
    assert content(tmp_path / "p" / "prediction.json")["left_out"] == ["tie point `far`"]
    assert CliRunner().invoke(app, ["check", str(project)]).exit_code == 2


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("six-image", "--predict", "--runs", 3), "two different things"),
        (("six-image", "--study", "1,2"), "give --runs as well"),
        (("six-image", "--resume"), "give --runs as well"),
        (("six-image", "--runs", 2, "--study", "1,x"), "not numbers of at least 0"),
        (("six-image", "--runs", 2, "--study", "-1"), "not numbers of at least 0"),
        ((FOLDER / "six_image_block", "--runs", 2, "--study", "0,1"), "there are none"),
        (("six-imag",), "did you mean `six-image`?"),
        (("nowhere/project.yaml",), "no kind of block and no project"),
    ],
)
def test_usage(arguments: tuple[object, ...], reason: str, tmp_path: Path) -> None:
    result = run(*arguments, "-o", tmp_path / "x")
    assert result.exit_code == 2
    assert reason in result.stderr
    assert not (tmp_path / "x").exists()
