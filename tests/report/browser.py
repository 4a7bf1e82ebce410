"""A real browser for the tests of report.html, and reports to open in it.

The fixtures are collected by ``conftest.py``: a test asks for ``page_of`` and gets pages of files::

    def test_something(page_of, sample_reports):
        page = page_of(sample_reports["six_image_mixed"])
        assert page.locator("h1").inner_text() == "six-image-mixed"

When the test ends, every page that it opened must have kept still: no error on the console, no request to the
network.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from splinebba_cli.jobs.adjust_job import AdjustOptions, run_adjustment

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ("circle_three_ways", "free_network", "six_image_block", "six_image_mixed")
WIDE, PHONE = (1280, 900), (390, 844)
_NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")
_OWN_SCHEMES = ("file:", "data:", "blob:", "about:")

PageOf = Callable[..., "Page"]


def browser_path() -> str | None:
    """The Chromium of this machine: of ``SPLINEBBA_BROWSER``, or found by its name."""
    names = (os.environ.get("SPLINEBBA_BROWSER", ""), *_NAMES)
    return next(filter(None, map(shutil.which, filter(None, names))), None)


@dataclass
class Watched:
    """What pages have done that a report must not do."""

    errors: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)

    def watch(self, page: Page) -> None:
        """Listen to a page before it opens anything."""
        page.on("console", lambda message: self._said(message.type, message.text))
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("request", lambda request: self._asked(request.url))
        page.on("dialog", lambda dialog: (self.errors.append(f"dialog: {dialog.message}"), dialog.dismiss()))

    def _said(self, kind: str, text: str) -> None:
        if kind in ("error", "warning"):
            self.errors.append(text)

    def _asked(self, url: str) -> None:
        if not url.startswith(_OWN_SCHEMES):
            self.requests.append(url)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Chromium without a window; of one module: its event loop would disturb others that run one."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    executable = browser_path()
    if executable is None:
        pytest.skip("no Chromium, Chrome or Edge on this machine (SPLINEBBA_BROWSER names one)")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=executable, args=["--no-sandbox", "--disable-gpu"])
        yield started
        started.close()


@pytest.fixture
def watched() -> Watched:
    """What the pages of this test have done that they must not do."""
    return Watched()


@pytest.fixture
def page_of(browser: Browser, watched: Watched) -> Iterator[PageOf]:
    """Open a file: ``page_of(path, size=WIDE, scheme="light")``."""
    contexts = []

    def opened(path: Path, *, size: tuple[int, int] = WIDE, scheme: str = "light") -> Page:
        width, height = size
        context = browser.new_context(
            viewport={"width": width, "height": height},
            color_scheme=scheme,  # type: ignore[arg-type]
            has_touch=size == PHONE,
            reduced_motion="reduce",
        )
        contexts.append(context)
        context.set_default_timeout(60_000)  # of a loaded machine
        page = context.new_page()
        watched.watch(page)
        page.goto(path.resolve().as_uri())
        return page

    yield opened
    for context in contexts:
        context.close()
    assert (watched.errors, watched.requests) == ([], [])


@pytest.fixture(scope="session")
def sample_reports(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Path]:
    """``report.html`` of the sample projects, by the name of their folder; each is made when it is asked for."""
    return _Samples(tmp_path_factory.mktemp("samples"))


class _Samples(Mapping[str, Path]):
    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __getitem__(self, name: str) -> Path:
        target = self._folder / name.replace("/", "-")
        if not target.exists():
            run_adjustment(ROOT / "sample_projects" / name, AdjustOptions(output=target))
        return target / "report.html"

    def __iter__(self) -> Iterator[str]:
        return iter(SAMPLES)

    def __len__(self) -> int:
        return len(SAMPLES)
