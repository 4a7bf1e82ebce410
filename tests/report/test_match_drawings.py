"""`report` on the folder of a matching: the same pages from what is stored, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.errors import OutputError
from splinebba_cli.output.json_text import json_text
from splinebba_cli.output.match_folder import is_match_folder
from splinebba_cli.output.match_json import match_content
from splinebba_cli.output.provenance import provenance
from splinebba_cli.project.loading import load_project
from splinebba_cli.report.build import ReportFormat, report_of, write_report
from splinebba_cli.report.match_drawings import DRAWINGS_FILE
from splinebba_cli.report.match_report import write_match_reports
from tests.labelled_chains import known_matching, street


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("matched")
    loaded = load_project(street(folder), "matching")
    result = known_matching(loaded)
    content = match_content(result, MatchSettings(), provenance(loaded))
    (folder / "match.json").write_text(json_text(content), encoding="utf-8")
    write_match_reports(folder, result, content, ["text", "html"])
    return folder


@pytest.mark.parametrize(("format", "name"), [("html", "match.html"), ("text", "match.txt")])
def test_the_same_page_again(folder: Path, format: ReportFormat, name: str, tmp_path: Path) -> None:
    assert is_match_folder(folder)
    path = write_report(folder, format, tmp_path / name)
    assert path.read_bytes() == (folder / name).read_bytes()


def test_other_formats_lie_beside_it(folder: Path) -> None:
    assert write_report(folder, "markdown") == folder / "match.md"
    assert "## Images" in (folder / "match.md").read_text(encoding="utf-8")
    content = json.loads(report_of(folder, "json"))
    assert content["format"] == "splinebba-report/1"
    assert "match_images" in [block.get("figure") for s in content["sections"] for block in s["blocks"]]


@pytest.mark.parametrize(
    "text", [None, "[{}]", "[", '[{"image": 99, "height": 1, "frame": [], "strokes": []}]']
)
def test_lost_drawings_are_told(folder: Path, text: str | None, tmp_path: Path) -> None:
    for name in ("match.json", DRAWINGS_FILE):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    if text is None:
        (tmp_path / DRAWINGS_FILE).unlink()
    else:
        (tmp_path / DRAWINGS_FILE).write_text(text, encoding="utf-8")
    with pytest.raises(OutputError) as caught:
        report_of(tmp_path, "html")
    assert caught.value.code == "SBB602"
    assert "MATCHED" in str(report_of(tmp_path, "text"))


def test_a_line_of_a_foreign_file_is_no_markup(folder: Path, tmp_path: Path) -> None:
    panels = json.loads((folder / DRAWINGS_FILE).read_text(encoding="utf-8"))
    panels[0]["strokes"][0].update(path='"><script>alert(1)</script>', kind='"><b>', says="<i>")
    (tmp_path / DRAWINGS_FILE).write_text(json.dumps(panels), encoding="utf-8")
    (tmp_path / "match.json").write_bytes((folder / "match.json").read_bytes())
    page = str(report_of(tmp_path, "html"))
    assert "alert(1)" in page and "<script>alert" not in page and '"><b>' not in page
