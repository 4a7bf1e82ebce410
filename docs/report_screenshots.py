"""Pictures of a report, one a section: ``python -m docs.report_screenshots RESULTS OUT``.

``--width 390`` shows the page of a phone, ``--scheme dark`` the dark theme. ``top.png`` is what is seen first;
``python -m docs.report_screenshots RESULTS --top docs/figures/report.png`` makes that alone.
Needs playwright and an installed Chromium, Chrome or Edge (``SPLINEBBA_BROWSER`` or on the PATH).
"""

from __future__ import annotations

import argparse
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from splinebba_cli.report.browser import browser_path


def take_screenshots(page: Page, out: Path) -> list[Path]:
    """The top of the page and every section, as ``NN-id.png`` in the order of the page."""
    out.mkdir(parents=True, exist_ok=True)
    paths = [out / "top.png"]
    page.screenshot(path=paths[0])
    for details in page.locator("main details").all():
        details.evaluate("details => { details.open = true; }")
    page.locator("nav").evaluate("nav => { nav.style.position = 'static'; }")
    for number, section in enumerate(page.locator("main > section[id]").all(), 1):
        paths.append(out / f"{number:02d}-{section.get_attribute('id')}.png")
        section.screenshot(path=paths[-1])
    return paths


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="result folder, or a report.html")
    parser.add_argument("out", type=Path, nargs="?", help="folder of the pictures")
    parser.add_argument("--top", type=Path, help="only the top of the page, into this file")
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--scheme", choices=["light", "dark"], default="light")
    arguments = parser.parse_args()
    if (arguments.out is None) == (arguments.top is None):
        parser.error("give OUT or --top")
    report = arguments.results
    report = report / "report.html" if report.is_dir() else report
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=browser_path(), args=["--no-sandbox"])
        size = {"width": arguments.width, "height": arguments.height}
        page = browser.new_page(viewport=size, color_scheme=arguments.scheme, reduced_motion="reduce")  # type: ignore[arg-type]
        page.goto(report.resolve().as_uri())
        if arguments.top is not None:
            page.screenshot(path=arguments.top)
            print(arguments.top)
        else:
            print(*take_screenshots(page, arguments.out), sep="\n")
        browser.close()


if __name__ == "__main__":
    main()
