"""Size and speed of a report in a browser: ``python -m benchmarks.report_size RESULTS``.

Prints how long the report takes to build, how large ``report.html`` is, and in Chromium, without a window: the time
until the page is there (DOMContentLoaded), the elements of its document, and for the longest table the time from a
click or a key until the sorted, filtered or next rows are laid out; medians of some repeats.

A block of 1 000 images (see the README of this folder for ``BLOCK.npz``)::

    python -m benchmarks.bench_project BLOCK.npz BLOCK
    splinebba adjust BLOCK -o BLOCK.results
    python -m benchmarks.report_size BLOCK.results
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.browser import browser_path
from splinebba_cli.report.build import write_report

if TYPE_CHECKING:
    from playwright.sync_api import Browser

LIMIT_MB = 15.0
_LOADED = """() => {
  const entry = performance.getEntriesByType('navigation')[0];
  return {seconds: entry.domContentLoadedEventEnd / 1000, elements: document.querySelectorAll('*').length,
          drawn: document.querySelectorAll('svg *').length, rows: document.querySelectorAll('tbody tr').length};
}"""
# what is done to the longest table; each ends with the layout of the rows that it shows
_LONGEST = """
  const sources = [...document.querySelectorAll('script.rows')];
  const longest = sources.reduce((a, b) => (Number(a.dataset.count) >= Number(b.dataset.count) ? a : b));
  const frame = longest.closest('.table');
  for (let part = frame.closest('details'); part; part = part.parentElement.closest('details')) part.open = true;
  const headings = [...frame.querySelectorAll('th .sort')];
  const input = frame.querySelector('input');
  const timed = (act) => {
    const start = performance.now();
    act();
    frame.getBoundingClientRect();
    return (performance.now() - start) / 1000;
  };
  const typed = (text) => timed(() => { input.value = text; input.dispatchEvent(new Event('change')); });
"""
_SORTED = f"""() => {{ {_LONGEST}
  const numeric = headings.filter((heading) => heading.parentElement.classList.contains('n'));
  return {{caption: frame.querySelector('caption').textContent, rows: Number(longest.dataset.count),
    number: timed(() => numeric[numeric.length - 1].click()), text: timed(() => headings[0].click())}};
}}"""
_FILTERED = f"""() => {{ {_LONGEST}
  return {{first: typed('1'), word: typed('9'), page: timed(() => frame.querySelector('.pager').children[3].click())}};
}}"""


def measure(report: Path, repeats: int) -> dict[str, Any]:
    """Figures of a page, the median of fresh browsers' pages.

    Parameters
    ----------
    report : path of report.html
    repeats : pages that are opened
    """
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_path(), args=["--no-sandbox"])
        loaded, acted = zip(*(_page(browser, report) for _ in range(repeats)), strict=True)
        browser.close()
    result = dict(loaded[0])
    result["seconds"] = statistics.median(page["seconds"] for page in loaded)
    if acted[0]:
        result["longest_table"] = {
            key: statistics.median(table[key] for table in acted) if isinstance(value, float) else value
            for key, value in acted[0].items()
        }
    return result


def _page(browser: Browser, report: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.goto(report.resolve().as_uri())
    loaded = page.evaluate(_LOADED)
    acted = {}
    if page.locator("script.rows").count():
        acted = {**page.evaluate(_SORTED), **page.evaluate(_FILTERED)}
    page.close()
    return loaded, acted


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="result folder")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        report = write_report(arguments.results, "html", Path(folder) / "report.html")
        built = time.perf_counter() - start
        megabytes = report.stat().st_size / 1e6
        figures = {"built_s": built, "size_mb": megabytes, **measure(report, arguments.repeats)}
    print(json.dumps(figures, indent=2, ensure_ascii=False))
    if megabytes > LIMIT_MB:
        raise SystemExit(f"the report is larger than {LIMIT_MB} MB")


if __name__ == "__main__":
    main()
