"""``splinebba fit`` as a user runs it: files, summary, JSON, refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner, Result

import splinebba_cli
from splinebba_cli.commands.app import app
from splinebba_cli.core.curves.natural_cubic import natural_cubic
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_curves import read_curves
from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.table_reader import TableReader
from splinebba_cli.project.yaml_source import read_yaml

runner = CliRunner()
ANGLE = np.linspace(0.0, np.pi, 60)
ARC = np.stack([5000.0 + 50.0 * np.cos(ANGLE), 3000.0 + 50.0 * np.sin(ANGLE), 100.0 + ANGLE], axis=1)


def run(*arguments: object) -> Result:
    return runner.invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def arc(tmp_path: Path) -> Path:
    path = tmp_path / "arc.csv"
    np.savetxt(path, ARC, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
    return path


def splines_of(path: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = yaml.safe_load(path.read_text(encoding="utf-8"))["splines"]
    return found


def test_text_summary_and_files(arc: Path) -> None:
    figure = arc.with_name("arc.svg")
    result = run("fit", arc, "--threshold-m", 0.01, "--figure", figure)
    assert result.exit_code == 0, result.output
    written = arc.with_name("arc.splines.yaml")
    (spline,) = splines_of(written)
    assert spline["id"] == "arc" and spline["role"] == "tie" and "sigma" not in spline
    row = next(line for line in result.stdout.splitlines() if line.lstrip().startswith("arc "))
    assert row.split()[1:4] == ["60", str(len(spline["knots"])), "0"]
    assert float(row.split()[4]) <= 10.0
    assert "Largest distance" in result.stdout and "[mm]" in result.stdout
    assert str(written) in result.stdout and str(figure) in result.stdout
    assert figure.read_text(encoding="utf-8").startswith("<?xml")


def test_the_block_is_part_of_a_project(arc: Path, tmp_path: Path) -> None:
    """Pasted into a project, it loads back to the curve that was fitted, and that keeps the threshold."""
    assert run("simulate", "six-image-mixed", "-o", tmp_path / "block").exit_code == 0
    result = run("fit", arc, "--role", "control", "--sigma", "0.02", "-o", tmp_path / "s.yaml")
    assert result.exit_code == 0, result.output
    project = tmp_path / "block" / "project.yaml"
    data = yaml.safe_load(project.read_text(encoding="utf-8"))
    data["splines"] += splines_of(tmp_path / "s.yaml")
    project.write_text(yaml.safe_dump(data, allow_unicode=True), encoding="utf-8")
    loaded = load_project(project)
    assert {item.code for item in loaded.diagnostics if "arc" in item.message} <= {"SBB310"}  # not measured
    collector, source = Collector(), read_yaml(project, Collector())
    assert source is not None
    reader = TableReader(source, project.parent, collector)
    rows = read_curves(Building(loaded.model, source, reader, collector))
    curve = rows.curves[rows.index()["arc"]]
    assert curve.role == "control" and (curve.sigma == 0.02).all()
    basis = natural_cubic(curve)
    coefficients = basis.coefficients_from_values(curve.values - ARC[0])
    distance = nearest_on_curve(basis, coefficients, ARC - ARC[0])[1]
    assert 0.005 < distance.max() <= 0.05 + 1e-9


def test_json(arc: Path) -> None:
    result = run("fit", arc, "--format", "json", "--id", "kerb")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    (spline,) = found["splines"]
    assert spline["id"] == "kerb" and spline["points"] == 60
    assert spline["knot_count"] == len(spline["knots"]) == len(spline["knot_parameters"])
    assert spline["rms_distance_m"] <= spline["largest_distance_m"] <= spline["threshold_m"] == 0.05
    assert found["output"] == str(arc.with_name("arc.splines.yaml")) and found["problems"] == []
    assert splines_of(Path(found["output"]))[0]["knots"] == spline["knots"]


def test_several_lines_of_geojson(tmp_path: Path) -> None:
    ring = np.vstack([ARC, ARC[:1]]).tolist()
    features = [
        {
            "type": "Feature",
            "properties": {"name": "lake"},
            "geometry": {"type": "Polygon", "coordinates": [ring]},
        },
        {
            "type": "Feature",
            "properties": {},
            "geometry": {"type": "LineString", "coordinates": ARC.tolist()},
        },
    ]
    path = tmp_path / "lines.geojson"
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}), encoding="utf-8")
    assert run("fit", path).exit_code == 0
    lake, other = splines_of(tmp_path / "lines.splines.yaml")
    assert lake["id"] == "lake" and lake["closed"] is True
    assert len(lake["knot_parameters"]) == len(lake["knots"]) + 1
    assert other["id"] == "lines-2" and "closed" not in other
    assert run("fit", path, "--id", "k", "--force").exit_code == 0
    assert [spline["id"] for spline in splines_of(tmp_path / "lines.splines.yaml")] == ["k-1", "k-2"]


def test_yaml_to_stdout(arc: Path) -> None:
    result = run("fit", arc, "-o", "-", "--corner-angle", 60)
    assert result.exit_code == 0
    assert yaml.safe_load(result.stdout)["splines"][0]["id"] == "arc"
    assert "Largest distance" in result.stderr
    assert list(arc.parent.glob("*.yaml")) == []


def test_files_are_not_replaced_unasked(arc: Path) -> None:
    assert run("fit", arc).exit_code == 0
    before = arc.with_name("arc.splines.yaml").read_bytes()
    again = run("fit", arc, "--threshold-m", 0.001)
    assert again.exit_code == 2 and "SBB603" in again.stderr
    assert arc.with_name("arc.splines.yaml").read_bytes() == before
    assert run("fit", arc, "--threshold-m", 0.001, "--force").exit_code == 0
    assert arc.with_name("arc.splines.yaml").read_bytes() != before


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_figures_are_the_same_every_time(arc: Path, suffix: str) -> None:
    first, second = arc.with_name(f"1.{suffix}"), arc.with_name(f"2.{suffix}")
    for figure in (first, second):
        assert run("fit", arc, "--figure", figure, "--force").exit_code == 0
    assert first.read_bytes() == second.read_bytes() and len(first.read_bytes()) > 5000


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--role", "control"], "SBB900"),
        (["--role", "control", "--sigma", "-1"], "SBB900"),
        (["--sigma", "0.1"], "SBB900"),
        (["--threshold-m", "0"], "SBB900"),
        (["--figure", "a.xlsx"], "SBB900"),
        (["--columns", "a,b,c"], "SBB402"),
    ],
)
def test_refusals(arc: Path, arguments: list[str], code: str) -> None:
    result = run("fit", arc, *arguments)
    assert result.exit_code == 2
    assert code in result.stderr and result.stdout == ""
    assert list(arc.parent.glob("*.yaml")) == []


def test_bad_points(tmp_path: Path) -> None:
    path = tmp_path / "p.csv"
    path.write_text("x,y,z\n1,2,nan\n2,3,4\n", encoding="utf-8")
    result = run("fit", path)
    assert result.exit_code == 2
    assert "p.csv:2:5" in result.stderr and "1 error in the points; nothing was written" in result.stderr
    path.write_text("x,y,z\n1,2,3\n1,2,3\n", encoding="utf-8")
    result = run("fit", path, "--format", "json")
    assert result.exit_code == 2
    (problem,) = json.loads(result.stdout)["problems"]
    assert problem["code"] == "SBB320" and "line `p`" in problem["message"]
    path.write_text("id,x,y,z\na,1,2,3\n,2,3,4\n", encoding="utf-8")
    assert "SBB403" in run("fit", path).stderr


def test_warnings(tmp_path: Path) -> None:
    path = tmp_path / "ring.csv"
    np.savetxt(path, np.vstack([ARC, ARC[:1]]), delimiter=",", header="x,y,z", comments="")
    assert "SBB324" in run("fit", path, "-o", "-").stderr
    assert "SBB324" not in run("fit", path, "-o", "-", "--closed").stderr
    rough = np.column_stack([np.arange(60.0), np.random.default_rng(2).normal(size=(60, 2))])
    np.savetxt(path, rough, delimiter=",", header="x,y,z", comments="")
    assert "SBB323" in run("fit", path, "-o", "-").stderr


def test_from_python() -> None:
    fit = splinebba_cli.fit_spline(ARC, 0.01)
    assert fit.largest_distance <= 0.01 and len(fit.knots) < 15
