"""match.html in a browser: fits a phone, has no violation of WCAG, says what a chain is when it is pointed at."""

from __future__ import annotations

from pathlib import Path

import pytest

from splinebba_cli.core.matching.settings import MatchSettings
from splinebba_cli.output.match_json import match_content
from splinebba_cli.output.provenance import provenance
from splinebba_cli.project.loading import load_project
from splinebba_cli.report.match_report import write_match_reports
from tests.labelled_chains import known_matching, street
from tests.report.browser import PHONE, PageOf
from tests.report.test_report_accessibility import SHORTENED, violations


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("street")
    loaded = load_project(street(folder), "matching")
    result = known_matching(loaded)
    content = match_content(result, MatchSettings(), provenance(loaded))
    write_match_reports(folder, result, content, ["html"])
    return folder / "match.html"


def test_on_a_phone(page_of: PageOf, report: Path) -> None:
    page = page_of(report, scheme="dark", size=PHONE)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.evaluate(SHORTENED)
    assert violations(page) == []


def test_a_chain_says_what_it_is(page_of: PageOf, report: Path) -> None:
    page = page_of(report)
    chain = page.locator(".panel path.chain-matched").first
    chain.scroll_into_view_if_needed()
    chain.hover(force=True)
    page.wait_for_function("!document.querySelector('.tip').hidden")
    text = page.locator(".tip").inner_text()
    assert "chain " in text and "spline kerb-" in text
