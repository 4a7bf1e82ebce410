"""The page against WCAG 2 A and AA, by axe-core, light and dark, wide and on the phone."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.report.browser import PHONE, WIDE, PageOf

LONG = os.environ.get("SPLINEBBA_LONG") == "1"  # the page with all its rows and drawings
SHORTENED = """
    for (const row of document.querySelectorAll('tbody tr:nth-child(n+4):not(.marked)')) row.remove();
    for (const drawing of document.querySelectorAll('figure svg')) drawing.replaceChildren();
"""
RULES = {"runOnly": {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}}


def violations(page: object) -> list[str]:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core is not installed")
    found = axe.Axe().run(page, options={**RULES, "resultTypes": ["violations"]}).response["violations"]
    return [
        f"{item['id']}: {node['target']} {node['failureSummary']}" for item in found for node in item["nodes"]
    ]


@pytest.mark.parametrize(("scheme", "size"), [("light", WIDE), ("dark", PHONE)])
def test_no_violation(
    page_of: PageOf, sample_reports: Mapping[str, Path], scheme: str, size: tuple[int, int]
) -> None:
    page = page_of(sample_reports["six_image_mixed"], scheme=scheme, size=size)
    page.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")
    page.locator("th .sort").first.click()
    page.locator(".tools button[aria-pressed]").first.click()
    if not LONG:  # a row is as good as the other
        page.evaluate(SHORTENED)
    assert violations(page) == []


def test_violations_are_found(page_of: PageOf, tmp_path: Path) -> None:
    bad = tmp_path / "bad.html"
    bad.write_text(
        '<!doctype html><html lang="en"><title>t</title><body style="background:#fff"><main>'
        '<p style="color:#aaa">pale</p><button></button>',
        encoding="utf-8",
    )
    assert {line.split(":")[0] for line in violations(page_of(bad))} == {"color-contrast", "button-name"}
