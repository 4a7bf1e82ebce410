"""Ids and names that try to be markup, script or layout stay text: in the page, in its data, in every format."""

from __future__ import annotations

import json
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from splinebba_cli.core.result import Problem
from splinebba_cli.report.build import write_report
from splinebba_cli.report.printable import one_line
from tests.output.factory import Loaded, make_result, write_results
from tests.report.browser import PHONE, PageOf, Watched

EVIL = (
    "</script><script>document.title='run'</script>",
    "<img src=x onerror=\"document.title='run'\">",
    "<!--<script>",
    "]]></svg><style>*{display:none}</style>",
    "\"'`|\\ *a* [b](javascript:alert(1)) ${x} {{ 7*7 }} $x_1$",
    "line\nbreak\ttab\x1b[31m",
    "\u202egnp.exe\u2066\u200f",
    "javascript:document.title='run'",
    "x" * 300,
    "&lt;b&gt;&amp;",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A block whose ids are hostile, with enough images that their table is data of the page."""
    result = make_result(images=130, splines=len(EVIL), points=120)
    network = result.network
    named = [f"{EVIL[i % len(EVIL)]}{i}" for i in range(130)]
    images = replace(network.images, ids=tuple(named))
    points = replace(network.points, ids=tuple(named[:120]))
    curves = tuple(replace(curve, id=evil) for curve, evil in zip(network.curves, EVIL, strict=True))
    problems = tuple(Problem("SBB520", "warning", f"{evil} is odd", f"image `{evil}`", evil) for evil in EVIL)
    result = replace(
        result,
        network=replace(network, images=images, points=points, curves=curves),
        problems=problems,
    )
    path = tmp_path_factory.mktemp("hostile") / "out"
    write_results(path, result, loaded=Loaded(path=Path("a</style>.yaml"), name=EVIL[0] + EVIL[6]))
    return path


def test_nothing_of_theirs_runs_and_the_page_is_whole(page_of: PageOf, folder: Path) -> None:
    page = page_of(folder / "report.html", size=PHONE)
    assert page.title().startswith(EVIL[0])  # its text, not `run`
    assert page.locator("script:not([type])").count() == 1
    assert page.locator("img").count() == 0
    assert page.locator("nav a").count() == page.locator("main > section[id]").count() > 5
    assert page.locator(".verdict h2").is_visible()
    page.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE[0]
    table = page.locator(".table", has=page.locator("script.rows")).first
    table.get_by_role("searchbox").fill("</script><script>")
    table.get_by_role("searchbox").press("Enter")
    assert table.locator("tbody th").first.inner_text().startswith(EVIL[0])
    assert table.locator("output").inner_text() == "13 of 130 rows"
    assert not page.title().startswith("run")


def test_the_policy_lets_no_other_script_run(page_of: PageOf, folder: Path, watched: Watched) -> None:
    page = page_of(folder / "report.html")
    page.evaluate(
        "const script = document.createElement('script'); script.textContent = \"document.title = 'run'\";"
        "document.body.append(script)"
    )
    page.evaluate(
        "document.body.insertAdjacentHTML('beforeend', '<b onclick=\"document.title=`run`\">x</b>')"
    )
    page.locator("body > b").dispatch_event("click")
    page.evaluate("document.body.insertAdjacentHTML('beforeend', '<img src=\"http://localhost:9/a.png\">')")
    page.wait_for_timeout(50)
    assert page.title() != "run"
    assert len(watched.errors) == 3 and all("Content Security Policy" in error for error in watched.errors)
    watched.errors.clear()
    assert watched.requests in ([], ["http://localhost:9/a.png"])  # asked for and refused
    watched.requests.clear()


def test_json_is_json(folder: Path) -> None:
    write_report(folder, "json")

    def refuse(text: str) -> float:
        raise AssertionError(text)

    content = json.loads((folder / "report.json").read_text(encoding="utf-8"), parse_constant=refuse)
    tables = [block for section in content["sections"] for block in section["blocks"] if "rows" in block]
    assert any(row[0] == f"{EVIL[0]}0" for table in tables for row in table["rows"])


@pytest.mark.parametrize("format", ["text", "markdown"])
def test_plain_formats_keep_their_lines(folder: Path, tmp_path: Path, format: str) -> None:
    path = write_report(folder, format, tmp_path / "report")  # type: ignore[arg-type]
    text = path.read_text(encoding="utf-8")
    assert all(character == "\n" or character.isprintable() for character in text)
    assert "line\\nbreak\\ttab\\x1b" in text.replace("\\\\", "\\").replace("\\[", "[")


def test_markdown_is_no_markup(folder: Path, tmp_path: Path) -> None:
    markdown_it = pytest.importorskip("markdown_it", reason="markdown-it-py is not installed")
    write_report(folder, "markdown", tmp_path / "report.md")
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    html = markdown_it.MarkdownIt("commonmark", {"html": True}).enable("table").render(text)
    found = _Tags()
    found.feed(html)
    structure = {"h1", "h2", "p", "blockquote", "strong", "ul", "li", "br", "code", "details", "summary"}
    assert found.names <= structure | {"table", "thead", "tbody", "tr", "th", "td"}
    texts = "".join(found.texts)
    assert all(one_line(evil) in texts for evil in EVIL)
    columns = [line.replace("\\|", "").count("|") for line in text.splitlines() if line.startswith("|")]
    assert min(columns) >= 3


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.texts: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.add(tag)

    def handle_data(self, data: str) -> None:
        self.texts.append(data)
