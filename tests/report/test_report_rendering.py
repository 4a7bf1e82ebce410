"""Text, HTML, console: complete, escaped, self-contained, stable, and the same when built again."""

from __future__ import annotations

import io
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from splinebba_cli.core.prior_residuals import PriorResiduals
from splinebba_cli.errors import OutputError
from splinebba_cli.report.build import write_report
from splinebba_cli.report.text import console_summary
from tests.output.factory import Loaded, make_result, write_results

_VOID = {"meta", "br", "input", "link", "path", "use", "rect"}


class _Checker(HTMLParser):
    """Balance of tags, ids, references to elsewhere."""

    def __init__(self) -> None:
        super().__init__()
        self.stack: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.headers_without_scope = 0
        self.tables_without_caption = 0
        self._captioned = True

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.ids += [values["id"] or ""] if "id" in values else []
        self.links += [values[key] or "" for key in ("href", "src") if key in values]
        self.headers_without_scope += tag == "th" and "scope" not in values
        if tag == "table":
            self._captioned = False
        if tag == "caption":
            self._captioned = True
        if tag == "tbody":
            self.tables_without_caption += not self._captioned
        if tag not in _VOID:
            self.stack.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in _VOID:
            self.stack.pop()

    def handle_endtag(self, tag: str) -> None:
        if tag not in _VOID:
            assert self.stack.pop() == tag


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "out"
    write_results(path, make_result(), loaded=Loaded())
    return path


@pytest.mark.parametrize(("name", "fmt"), [("report.txt", "text"), ("report.html", "html")])
def test_built_again_from_the_folder(folder: Path, tmp_path: Path, name: str, fmt: str) -> None:
    assert write_report(folder, fmt, tmp_path / "again") == tmp_path / "again"  # type: ignore[arg-type]
    assert (tmp_path / "again").read_bytes() == (folder / name).read_bytes()


def test_not_a_result_folder(tmp_path: Path) -> None:
    with pytest.raises(OutputError) as caught:
        write_report(tmp_path, "text")
    assert caught.value.code == "SBB602"


def test_html_is_well_formed_accessible_and_self_contained(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    checker = _Checker()
    checker.feed(text)
    assert checker.stack == []
    assert len(checker.ids) == len(set(checker.ids))
    assert all(link.startswith("#") and link[1:] in checker.ids for link in checker.links)
    assert checker.headers_without_scope == 0
    assert checker.tables_without_caption == 0
    assert not re.search(r"https?://(?!www\.w3\.org/)", text)
    assert "@import" not in text
    assert text.count("<svg") == 16
    assert text.count("<figure") == 14  # the vectors of three images are one


def test_html_escapes_what_people_wrote(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert "Six images &amp; &lt;two&gt; splines" in text
    assert "<code>kerb-&lt;1&gt;</code>" in text
    assert "<two>" not in text


def test_hostile_ids_in_tables_and_figures(tmp_path: Path) -> None:
    result = make_result()
    evil = "<script>alert(1)</script>$x_1$\n]]>"
    images = replace(result.network.images, ids=(evil, "--><b>", "[bold]"))
    curves = tuple(replace(curve, id=f"{evil}{i}") for i, curve in enumerate(result.network.curves))
    result = replace(result, network=replace(result.network, images=images, curves=curves))
    write_results(tmp_path / "out", result, loaded=Loaded(name=evil))
    text = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "<b>" not in text
    checker = _Checker()
    checker.feed(text)
    assert checker.stack == []
    output = io.StringIO()
    Console(file=output, width=140).print(console_summary(result))
    assert "[bold]" in output.getvalue()


def test_figures_take_the_colours_of_the_page(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    drawings = re.findall(r"<svg.*?</svg>", text, flags=re.DOTALL)
    for drawing in drawings:
        colours = set(re.findall(r"#[0-9a-f]{6}\b", drawing))
        assert colours <= {"#ffffff", "#000000"}, colours
        if "xmlns=" in drawing:  # drawn by matplotlib; the others are coloured by classes
            assert "var(--ink)" in drawing
        assert "<metadata" not in drawing


def test_text_is_aligned_and_leads_with_the_verdict(folder: Path) -> None:
    lines = (folder / "report.txt").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "Six images & <two> splines"
    assert "ADJUSTED, WITH 1 WARNING" in lines[:6]
    header = next(number for number, line in enumerate(lines) if line.startswith("Image") and "X [m]" in line)
    assert len(lines[header]) == len(lines[header + 1]) == len(lines[header + 2])
    assert lines[header + 3].endswith(" *")
    assert all(line == line.rstrip() for line in lines)
    assert lines.index("Problems and suggestions") < lines.index("Statistics") < lines.index("Splines")


def test_console_summary_is_compact(monkeypatch: pytest.MonkeyPatch) -> None:
    output = io.StringIO()
    result = make_result(images=36, splines=20, points=50)
    Console(file=output, width=160, color_system=None).print(console_summary(result))
    text = output.getvalue()
    assert text.startswith("Adjusted, with 1 warning")
    assert "… and 24 more (exterior_orientation.csv)" in text
    assert "… and 8 more (result.json)" in text
    assert text.index("SBB520") < text.index("Redundancy") < text.index("Adjusted exterior")
    assert text.count("\n") < 60


def test_console_shows_the_worst_of_many() -> None:
    output = io.StringIO()
    result = make_result(images=36, splines=20)
    dispersion = result.images.dispersion.copy()
    dispersion[29, 3:, 3:] = np.eye(3) * 49.0
    result = replace(result, images=replace(result.images, dispersion=dispersion))
    Console(file=output, width=160, color_system=None).print(console_summary(result))
    lines = output.getvalue().splitlines()
    head = next(
        number for number, line in enumerate(lines) if "orientation" in line and "the largest σ" in line
    )
    rule = next(number for number in range(head, len(lines)) if "───" in lines[number])
    assert lines[rule + 1].split()[0] == result.network.images.ids[29]


def test_narrow_console_keeps_its_lines_short() -> None:
    output = io.StringIO()
    Console(file=output, width=80, color_system=None).print(console_summary(make_result()))
    text = output.getvalue()
    assert max(map(len, text.replace("\u0302", "").splitlines())) <= 80
    assert "572002.765" in text
    assert "columns left out" in text


@pytest.mark.parametrize(
    "counts",
    [
        {"splines": 0},
        {"points": 0},
        {"splines": 0, "points": 0},
        {"images": 1, "splines": 1, "knots": 2},
        {"images": 70},
    ],
)
def test_unusual_blocks(tmp_path: Path, counts: dict[str, int]) -> None:
    write_results(tmp_path / "out", make_result(**counts), loaded=Loaded())
    assert (tmp_path / "out" / "report.html").stat().st_size > 20_000


def test_unknown_values_everywhere(tmp_path: Path) -> None:
    result = make_result(iterations=(), prior_residuals=PriorResiduals.of_rows(()))
    camera = replace(result.network.cameras[0], pixel_size_mm=None, format_mm=None)
    images = replace(result.images, dispersion=np.full((3, 6, 6), np.nan))
    curves = tuple(
        replace(
            curve,
            knot_sigma=np.full_like(curve.knot_sigma, np.nan),
            along_sigma=np.full_like(curve.along_sigma, np.nan),
            sample_across=np.full_like(curve.sample_across, np.nan),
            sigma_across_max=np.nan,
            sigma_across_mean=np.nan,
            rms_across_mm=np.nan,
        )
        for curve in result.curves
    )
    result = replace(result, network=replace(result.network, cameras=(camera,)), images=images, curves=curves)
    write_results(tmp_path / "out", result, loaded=Loaded())
    text = (tmp_path / "out" / "report.txt").read_text(encoding="utf-8")
    assert "nan" not in text.replace("Provenance", "")
    Console(file=io.StringIO()).print(console_summary(result))
