"""report.html in a real browser: its script runs, nothing is fetched from elsewhere, nothing complains."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from splinebba_cli.jobs.adjust_job import AdjustOptions, run_adjustment
from tests.output.factory import make_result, write_results
from tests.report.browser import PHONE, ROOT, SAMPLES, WIDE, PageOf, Watched

LONG = os.environ.get("SPLINEBBA_LONG") == "1"
DISSERTATION = sorted(path.parent.name for path in ROOT.glob("sample_projects/dissertation/*/project.yaml"))
UNSOLVABLE = {"section_5_3", "table_5_7", "table_5_8", "table_5_12"}  # as the dissertation finds, or nearly


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page") / "out"
    write_results(folder, make_result())
    return folder / "report.html"


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_keep_still_and_fit_the_phone(
    page_of: PageOf, sample_reports: Mapping[str, Path], name: str
) -> None:
    """No error and no request (asked when the test ends), no sideways scrolling of the page."""
    page = page_of(sample_reports[name], size=PHONE)
    assert page.locator(".verdict h2").inner_text().startswith("Adjusted")
    page.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")
    width = page.evaluate("[document.documentElement.scrollWidth, document.body.scrollWidth]")
    assert width == [PHONE[0], PHONE[0]]


@pytest.mark.skipif(not LONG, reason="SPLINEBBA_LONG=1 runs it")
@pytest.mark.parametrize("name", [name for name in DISSERTATION if name not in UNSOLVABLE])
def test_projects_of_the_dissertation_keep_still(page_of: PageOf, tmp_path: Path, name: str) -> None:
    run_adjustment(ROOT / "sample_projects/dissertation" / name, AdjustOptions(output=tmp_path / "out"))
    page = page_of(tmp_path / "out" / "report.html", size=PHONE)
    assert page.locator("main > section").count() > 5
    assert page.evaluate("document.documentElement.scrollWidth") == PHONE[0]


def test_errors_and_requests_are_noticed(page_of: PageOf, watched: Watched, tmp_path: Path) -> None:
    broken = tmp_path / "broken.html"
    broken.write_text(
        '<!doctype html><script>nothing_of_the_kind()</script><img src="http://localhost:9/a.png" alt="">',
        encoding="utf-8",
    )
    page_of(broken)
    assert any("nothing_of_the_kind" in error for error in watched.errors)
    assert watched.requests == ["http://localhost:9/a.png"]
    watched.errors.clear()
    watched.requests.clear()


def test_theme_of_the_system_and_of_the_reader(page_of: PageOf, report: Path) -> None:
    background = "getComputedStyle(document.body).backgroundColor"
    light, dark = "rgb(244, 245, 247)", "rgb(18, 22, 28)"
    page = page_of(report, scheme="dark")
    assert page.evaluate(background) == dark
    page.get_by_role("button", name="Light theme").click()
    assert page.evaluate(background) == light
    page.reload()
    assert page.evaluate(background) == light  # remembered
    page.get_by_role("button", name="Dark theme").click()
    assert page.evaluate(background) == dark


def test_navigation_wide_and_on_the_phone(page_of: PageOf, report: Path) -> None:
    page = page_of(report, size=WIDE)
    links = page.locator("nav a")
    assert links.count() == page.locator("main > section[id]").count()
    links.nth(5).click()
    target = page.locator("main > section[id]").nth(5)
    assert abs(target.bounding_box()["y"]) < 100  # type: ignore[index]
    expect = pytest.importorskip("playwright.sync_api").expect
    expect(links.nth(5)).to_have_attribute("aria-current", "true")
    small = page_of(report, size=PHONE)
    assert not small.locator("nav a").first.is_visible()
    small.locator("nav summary").click()
    small.locator("nav a").nth(3).click()
    assert not small.locator("nav a").first.is_visible()


def test_paper_is_light_open_and_without_controls(page_of: PageOf, report: Path) -> None:
    page = page_of(report, scheme="dark")
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert page.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
    assert page.locator(".kicker").evaluate("p => getComputedStyle(p).color") == "rgb(31, 95, 168)"
    assert page.locator("main details:not([open])").count() == 0
    for hidden in ("nav", ".theme", ".tools"):
        assert page.locator(f"{hidden}:visible").count() == 0
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.locator("main details:not([open])").count() > 0


def test_figures_have_names(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    named = "svg => (svg.closest('[aria-label]') ?? svg).getAttribute('aria-label')"
    names = [figure.evaluate(named) for figure in page.locator("main svg").all()]
    assert len(names) > 5
    assert all(len(name or "") > 10 for name in names)
    labels = [figure.get_attribute("aria-label") for figure in page.locator("figure").all()]
    assert len(labels) == len(set(labels)) > 5 and all(labels)


def test_only_tables_that_scroll_are_stops_of_the_keyboard(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    page.locator("main details").first.evaluate("part => { part.open = true; }")
    expect = pytest.importorskip("playwright.sync_api").expect
    small = page.locator("#residuals .table .scroll").first
    expect(small).not_to_have_attribute("tabindex", "0")
    page.set_viewport_size({"width": 390, "height": 800})
    expect(small).to_have_attribute("tabindex", "0")
