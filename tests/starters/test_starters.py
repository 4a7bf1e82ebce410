"""Every starter adjusts at once, is the same each time, and its notes explain what its report says."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import yaml

from splinebba_cli.errors import FitError, PointsFileError, UsageError
from splinebba_cli.jobs.adjust_job import AdjustOptions, AdjustOutcome, run_adjustment
from splinebba_cli.starters.catalogue import OF_POLYLINES, TEMPLATES, Polyline, Starter, build
from splinebba_cli.starters.folder import write_starter


@pytest.fixture(scope="module", params=sorted(TEMPLATES))
def starter(request: pytest.FixtureRequest) -> tuple[str, Starter]:
    return request.param, build(request.param)


@pytest.fixture(scope="module")
def adjusted(
    starter: tuple[str, Starter], tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path, AdjustOutcome]:
    name, made = starter
    folder = tmp_path_factory.mktemp("starters") / name
    write_starter(folder, made.files)
    return name, folder, run_adjustment(folder, AdjustOptions(html=False))


def test_accepted_and_without_warnings(adjusted: tuple[str, Path, AdjustOutcome]) -> None:
    _, _, outcome = adjusted
    assert outcome.accepted
    assert outcome.loaded.diagnostics == ()
    assert {problem.severity for problem in outcome.problems} <= {"info"}
    assert outcome.content["statistics"]["global_test"]["passed"]


def test_notes_explain_every_finding(adjusted: tuple[str, Path, AdjustOutcome]) -> None:
    _, folder, outcome = adjusted
    notes = (folder / "README.md").read_text(encoding="utf-8")
    explained = set(re.findall(r"^- (SBB\d{3}): ", notes, flags=re.MULTILINE))
    assert {problem.code for problem in outcome.problems} <= explained


def test_notes_name_every_file(starter: tuple[str, Starter]) -> None:
    _, made = starter
    named = set(re.findall(r"\| `([\w.]+)` \|", made.files["README.md"]))
    assert named == set(made.files) - {"README.md"}


def largest_sigma_m(content: dict[str, Any]) -> float:
    return max(image["sigma"][key] for image in content["images"] for key in "xyz")


def test_sigma_are_sensible(adjusted: tuple[str, Path, AdjustOutcome]) -> None:
    """Stations to less than the prior σ or a few hundredths of the distance, and not to nothing."""
    name, _, outcome = adjusted
    low, high = {"aerial": (0.02, 0.12), "close-range": (1e-4, 2e-3), "control-splines": (0.1, 8.9)}[name]
    assert low < largest_sigma_m(outcome.content) < high
    assert 0.9 < outcome.content["statistics"]["sigma0"] < 1.1
    across = [s["sigma_across"]["mean"] for s in outcome.content["splines"]]
    assert all(0.0 < value < 0.1 for value in across)


def test_same_bytes_twice(starter: tuple[str, Starter]) -> None:
    name, made = starter
    assert build(name).files == made.files


def test_schema_lies_beside_and_agrees(starter: tuple[str, Starter]) -> None:
    _, made = starter
    text = made.files["project.yaml"]
    first = text.splitlines()[0]
    assert first == "# yaml-language-server: $schema=project.schema.json"
    schema = json.loads(made.files["project.schema.json"])
    errors = jsonschema.Draft202012Validator(schema).iter_errors(yaml.safe_load(text))
    assert [error.message for error in errors] == []


def test_nothing_is_left_to_fill_in(starter: tuple[str, Starter]) -> None:
    _, made = starter
    assert [name for name, text in made.files.items() if "${" in text] == []


def lines_file(folder: Path, **lines: list[tuple[float, float, float]]) -> Polyline:
    rows = [f"{name},{x},{y},{z}" for name, points in lines.items() for x, y, z in points]
    path = folder / "measured lines.csv"
    path.write_text("spline,x,y,z\n" + "\n".join(rows) + "\n", encoding="utf-8")
    return Polyline(path)


def winding(x: float, y: float, swing: float = 150.0) -> list[tuple[float, float, float]]:
    t = np.linspace(0.0, 1.0, 40)
    xyz = np.column_stack([x + 1000 * t, y + swing * np.sin(9 * t), 50 + 0.03 * swing * np.sin(7 * t)])
    return [(float(a), float(b), float(c)) for a, b, c in np.round(xyz, 2)]


def straight(x: float, y: float) -> list[tuple[float, float, float]]:
    return [(x + 100.0 * k, y + 30.0 * k, 50.0) for k in range(11)]


def test_own_polyline(tmp_path: Path) -> None:
    polyline = lines_file(tmp_path, **{"0101": winding(5000, 7000), "shore": winding(5000, 7250)})
    made = build(OF_POLYLINES, polyline)
    write_starter(tmp_path / "own", made.files)
    outcome = run_adjustment(tmp_path / "own", AdjustOptions(html=False))
    assert outcome.accepted
    assert [spline["id"] for spline in outcome.content["splines"]] == ["0101", "shore"]
    assert made.files["lines.csv"] == polyline.file.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        ({"a": straight(5000, 7000)}, "all of it lies on one straight line"),
        ({"a": straight(5000, 7000), "b": straight(5000, 7200)}, "undetermined"),
        ({"a": winding(5000, 7000, 2.0)}, "standard deviations of up to"),
    ],
    ids=["one straight line", "two parallel ones", "hardly bent"],
)
def test_lines_that_carry_no_block(lines: dict[str, Any], why: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="cannot carry a block") as caught:
        build(OF_POLYLINES, lines_file(tmp_path, **lines))
    assert caught.value.code == "SBB821"
    assert why in caught.value.message
    assert "straight" in caught.value.help


def test_lines_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="one straight line"):
        build(OF_POLYLINES, lines_file(tmp_path, mast=[(5000, 7000, 3), (5000, 7000, 30)]))
    with pytest.raises(FitError, match="line `a`"):
        build(OF_POLYLINES, lines_file(tmp_path, a=[(5000, 7000, 3), (5000, 7000, 3)]))
    with pytest.raises(PointsFileError):
        build(OF_POLYLINES, Polyline(tmp_path / "nowhere.csv"))
