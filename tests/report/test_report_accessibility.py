"""The page against WCAG 2 A and AA, by axe-core, light and dark, wide and on the phone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.report.browser import PHONE, WIDE, PageOf

RULES = {"runOnly": {"type": "tag", "values": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]}}


def violations(page: object) -> list[str]:
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-core is not installed")
    # the inside of drawings has no background that axe could find: it takes half a minute to say so
    where = {"exclude": [["figure svg *"]]}
    options = {**RULES, "resultTypes": ["violations"]}
    found = axe.Axe().run(page, context=where, options=options).response["violations"]
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
    assert violations(page) == []


def test_violations_are_found(page_of: PageOf, tmp_path: Path) -> None:
    bad = tmp_path / "bad.html"
    bad.write_text(
        '<!doctype html><html lang="en"><title>t</title><body style="background:#fff"><main>'
        '<p style="color:#aaa">pale</p><button></button>',
        encoding="utf-8",
    )
    assert {line.split(":")[0] for line in violations(page_of(bad))} == {"color-contrast", "button-name"}
