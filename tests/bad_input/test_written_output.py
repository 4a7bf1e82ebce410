"""Ids that are right but odd come through every output unchanged; none of them acts where it is shown."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from splinebba_cli.commands.app import app
from splinebba_cli.project.loading import load_project
from splinebba_cli.project.plain_text import id_problem
from tests.bad_input.cases import BASES

#: New ids of the points, images and the spline of the project, all of which are allowed.
ODD = {
    "A1": "a,b", "A2": 'x"y', "A3": "#7", "A4": "<b>&amp;</b>", "A5": "it's", "t1": "-5", "t2": "a;b",
    "t3": "%0A::error::", "t4": "a=b", "t5": "日本 語", "101": "no", "102": "1e-6", "103": "[*&!|>'\"%@`]",
    "kerb": "#, \"{'<script>'}\"",
}  # fmt: skip
ACTS = re.compile(r"[=@\t\r]")
NUMBER = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?")


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project of `base/tables` with odd ids."""
    folder = tmp_path_factory.mktemp("odd") / "p"
    shutil.copytree(BASES / "tables", folder)
    for table in folder.glob("*.csv"):
        with table.open(encoding="utf-8", newline="") as stream:
            rows = [[ODD.get(cell, cell) for cell in row] for row in csv.reader(stream)]
        with table.open("w", encoding="utf-8", newline="") as stream:
            csv.writer(stream, quoting=csv.QUOTE_ALL).writerows(rows)
    text = (folder / "project.yaml").read_text(encoding="utf-8")
    text = text.replace("id: kerb", f"id: {json.dumps(ODD['kerb'])}")
    text = text.replace("name: harbour", "name: \"<i>'Häfen' & ]]>\"")
    text = text.replace(
        "    - table: traced.csv", "    - name: '100 % \"traced\", once'\n      table: traced.csv"
    )
    (folder / "project.yaml").write_text(text, encoding="utf-8")
    return folder / "project.yaml"


@pytest.fixture(scope="module")
def results(project: Path) -> Path:
    """Its results, and what was printed in `printed.txt` beside them."""
    folder = project.parent / "results"
    done = CliRunner().invoke(
        app, ["adjust", str(project), "-o", str(folder), "--junit", str(project.parent / "junit.xml")]
    )
    assert done.exit_code == 0, done.output
    (project.parent / "printed.txt").write_text(done.output, encoding="utf-8")
    return folder


def test_odd_ids_are_allowed() -> None:
    assert [id for id in ODD.values() if id_problem(id)] == []


def test_result_json_holds_them(results: Path) -> None:
    content = json.loads((results / "result.json").read_text(encoding="utf-8"))
    found = [one["id"] for key in ("points", "images", "splines") for one in content[key]]
    assert found == list(ODD.values())


def test_tables_hold_them(results: Path) -> None:
    names = set()
    for table in results.glob("*.csv"):
        with table.open(encoding="utf-8", newline="") as stream:
            header, *rows = list(csv.reader(stream, strict=True))
        assert {len(row) for row in rows} <= {len(header)}, table
        names |= {cell for row in rows for cell in row}
    assert set(ODD.values()) <= names


def test_no_cell_is_a_formula(results: Path) -> None:
    for table in results.glob("*.csv"):
        with table.open(encoding="utf-8", newline="") as stream:
            for row in csv.reader(stream):
                for cell in row:
                    assert not ACTS.match(cell), (table.name, cell)
                    assert cell[:1] not in ("-", "+") or NUMBER.fullmatch(cell), (table.name, cell)


def test_adjusted_project_has_them(results: Path) -> None:
    network = load_project(results / "adjusted.yaml").network
    splines = tuple(curve.id for curve in network.curves)
    assert (*network.points.ids, *network.images.ids, *splines) == tuple(ODD.values())
    assert network.curve_observations.group_names == ('100 % "traced", once',)


def test_html_escapes_them(results: Path) -> None:
    html = (results / "report.html").read_text(encoding="utf-8")
    assert "<b>&amp;</b>" not in html and "'<script>'" not in html and "<i>'" not in html
    assert "&lt;b&gt;&amp;amp;&lt;/b&gt;" in html


def test_junit_is_xml(project: Path, results: Path) -> None:
    tree = ElementTree.parse(project.parent / "junit.xml")
    assert tree.getroot()[0].attrib["name"] == "<i>'Häfen' & ]]>"


def test_annotations_are_one_line_each(project: Path) -> None:
    text = project.read_text(encoding="utf-8")
    broken = project.with_name("broken.yaml")
    broken.write_text(text.replace("points: {table: points.csv}", "points: []"), encoding="utf-8")
    said = CliRunner().invoke(app, ["check", str(broken), "--format", "github"]).stdout
    lines = said.splitlines()
    assert lines and all(line.startswith("::error file=") for line in lines)
    assert any("%250A" in line for line in lines)


def test_nothing_acts_on_a_terminal(project: Path, results: Path) -> None:
    for path in (project.parent / "printed.txt", results / "report.txt"):
        assert not re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e]", path.read_text(encoding="utf-8"))


def test_a_stored_result_does_not_act_on_a_terminal(results: Path, tmp_path: Path) -> None:
    folder = tmp_path / "stored"
    shutil.copytree(results, folder)
    path = folder / "result.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"no"', r'"\u001b[2J\u009b"'), encoding="utf-8")
    done = CliRunner().invoke(app, ["report", str(folder), "--format", "text"])
    assert done.exit_code == 0, done.output
    said = (folder / "report.txt").read_text(encoding="utf-8")
    assert "\x1b" not in said and "\x9b" not in said
    assert "␛[2J" in said
