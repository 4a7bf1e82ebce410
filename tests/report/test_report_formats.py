"""Markdown, JSON and PDF say what the page says; the same results give the same bytes."""

from __future__ import annotations

import json
import os
import re
import stat
import sys
from pathlib import Path
from typing import Any

import pytest

from splinebba_cli.errors import OutputError
from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.report.blocks import Column, Fact, Facts, Report, Section, Table, Verdict
from splinebba_cli.report.browser import VARIABLE, browser_path, print_to_pdf
from splinebba_cli.report.build import rendered, report_of, write_report
from splinebba_cli.report.json_report import render_json
from splinebba_cli.report.markdown import render_markdown
from splinebba_cli.report.pdf import dated_pdf
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report
from tests.output.factory import make_result, write_results
from tests.report import browser as test_browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("formats") / "out"
    write_results(path, make_result(images=40), html=False)
    return path


def _report(*blocks: Any) -> Report:
    return Report("T", "S", Verdict("bad", "No", "why"), Facts(()), (Section("s", "S", blocks),))


def test_sections_are_the_same_in_every_format(folder: Path) -> None:
    data = ResultData.load(folder)
    report = build_report(data)
    titles = [section.title for section in report.sections]
    assert len(titles) > 10
    html, text, markdown = (rendered(report, data, name) for name in ("html", "text", "markdown"))  # type: ignore[arg-type]
    assert re.findall(r'class="card">\n<h2>(.*?)</h2>', html) == titles
    assert re.findall(r"^## (.*)$", markdown, re.MULTILINE) == [t for t in titles if t != "Block plan"]
    assert all(f"\n{title}\n---" in text for title in titles if title != "Block plan")
    content = json.loads(rendered(report, data, "json"))
    assert [section["title"] for section in content["sections"]] == titles


@pytest.mark.parametrize("format", ["markdown", "json", "text"])
def test_same_bytes(folder: Path, format: str) -> None:
    assert report_of(folder, format) == report_of(folder, format)  # type: ignore[arg-type]


def test_json_has_raw_numbers_beside_their_units() -> None:
    facts = Facts(
        (
            Fact("raw", "12.3 mm", number=0.0123456, unit="m"),
            Fact("shown", "4.5 µm", "note"),
            Fact("no number", "5 of 6", tone="good"),
            Fact("NaN", "–", number=float("nan")),
        )
    )
    table = Table(
        "t", (Column("X", "m", 2, help="h"),), [(1.23456789,), (float("nan"),), (None,)], frozenset({1})
    )
    content = json.loads(render_json(_report(facts, table)))
    assert content["format"] == "splinebba-report/1"
    assert content["verdict"] == {"tone": "bad", "headline": "No", "detail": "why"}
    items, block = content["sections"][0]["blocks"][0]["items"], content["sections"][0]["blocks"][1]
    assert [(item.get("number", "none"), item.get("unit")) for item in items] == [
        (0.0123456, "m"),
        (4.5, "µm"),
        ("none", None),
        (None, ""),
    ]
    assert block["rows"] == [[1.23456789], [None], [None]]
    assert block["columns"] == [{"title": "X", "unit": "m", "decimals": 2, "numeric": True, "help": "h"}]
    assert block["marked"] == [1]


def test_key_facts_have_all_digits() -> None:
    data = ResultData(result_to_dict(make_result()))
    facts = json.loads(render_json(build_report(data)))["key_facts"]
    assert facts[0]["number"] == data["statistics"]["sigma0"]
    largest = max(image["sigma"][axis] for image in data["images"] for axis in "xyz")
    station = next(fact for fact in facts if "station" in fact["label"])
    assert (station["number"], station["unit"]) == (largest, "m")


def test_markdown_cuts_long_tables_and_says_where_they_are() -> None:
    rows = [(f"a|b{i}", float(i)) for i in range(30)]
    columns = (Column("Id", numeric=False), Column("X", "m", 1, help="east"))
    table = Table("Long", columns, rows, frozenset({1}), source="points.csv", folded=True)
    lines = render_markdown(_report(table)).splitlines()
    assert "> [!CAUTION]" in lines
    assert lines.count("| :-- | --: |") == 1
    assert "| a\\|b0 | 0.0 |" in lines and "| ⚠️ a\\|b1 | 1.0 |" in lines
    assert "| a\\|b24 | 24.0 |" in lines and not any("b25" in line for line in lines)
    assert "The first 25 of 30 rows; all are in `points.csv`." in lines
    assert "**X**: east." in lines
    assert lines[lines.index("<details>") + 1] == "<summary>Long (30 rows)</summary>"


def test_pdf_has_the_date_of_the_results() -> None:
    data = ResultData({"provenance": {"timestamps": {"written": "2025-03-04T05:06:07Z"}}})
    pdf = (
        b"%PDF /CreationDate (D:20261125230000+00'00')\n/ModDate (D:20261125230001+00'00') (D:20261125230001)"
    )
    dated = dated_pdf(pdf, data)
    assert len(dated) == len(pdf)
    assert dated.count(b"20250304050607+00'00'") == 2 and dated.endswith(b"(D:20261125230001)")
    assert dated_pdf(pdf, ResultData({"provenance": {}})) == pdf


def test_pdf_is_printed_by_the_browser(folder: Path, tmp_path: Path) -> None:
    program = test_browser.browser_path()
    if program is None:
        pytest.skip("no Chromium, Chrome or Edge on this machine (SPLINEBBA_BROWSER names one)")
    path = write_report(folder, "pdf", tmp_path / "report.pdf", program)
    pdf = path.read_bytes()
    assert pdf.startswith(b"%PDF-") and pdf.rstrip().endswith(b"%%EOF")
    pages = [float(size) for size in re.findall(rb"/MediaBox \[0 0 ([\d.]+) [\d.]+\]", pdf)]
    assert len(pages) > 3
    assert all(abs(width - 595) < 2 for width in pages)  # A4, upright
    written = ResultData.load(folder)["provenance"]["timestamps"]["written"]
    assert re.sub(r"\D", "", written).encode() in pdf


def test_no_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    assert browser_path() is None
    with pytest.raises(OutputError) as caught:
        print_to_pdf("")
    assert caught.value.code == "SBB620" and VARIABLE in caught.value.help
    monkeypatch.setenv(VARIABLE, "no-such-browser")
    with pytest.raises(OutputError, match="`no-such-browser`"):
        print_to_pdf("")


@pytest.mark.skipif(os.name == "nt", reason="programs of the test are shell scripts")
@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("echo no display >&2; exit 3", "ended with code 3 instead of a PDF: no display"),
        ("exit 0", "made no PDF"),
    ],
)
def test_browser_that_makes_nothing(tmp_path: Path, script: str, words: str) -> None:
    program = tmp_path / "browser"
    program.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    with pytest.raises(OutputError, match=words) as caught:
        print_to_pdf("", str(program))
    assert caught.value.code == "SBB621"
    program.write_text("no program", encoding="utf-8")
    with pytest.raises(OutputError, match="cannot be started") as caught:
        print_to_pdf("", str(program))
    assert caught.value.code == "SBB621"
