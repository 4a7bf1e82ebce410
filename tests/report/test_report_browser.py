"""report.html in a real browser: its script runs, nothing is fetched from elsewhere, nothing complains."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.report.browser import SAMPLES, PageOf, Watched


@pytest.mark.parametrize("name", SAMPLES)
def test_no_error_and_no_request(page_of: PageOf, sample_reports: Mapping[str, Path], name: str) -> None:
    page = page_of(sample_reports[name])  # what it must not do is asked when the test ends
    assert page.locator(".verdict h2").inner_text().startswith("Adjusted")


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
