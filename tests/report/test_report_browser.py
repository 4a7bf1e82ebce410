"""report.html in a real browser: its script runs, nothing is fetched from elsewhere."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.output.factory import make_result, write_results

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--enable-logging=stderr", "--virtual-time-budget=5000",
)  # fmt: skip


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> subprocess.CompletedProcess[str]:
    """The page after its script has run, and what the console says."""
    if BROWSER is None:
        pytest.skip("no chromium and no chrome on this machine")
    folder = tmp_path_factory.mktemp("browser")
    write_results(folder / "out", make_result())
    return opened_page(folder / "out" / "report.html", folder / "profile")


def opened_page(page: Path, profile: Path) -> subprocess.CompletedProcess[str]:
    """DOM on stdout, console on stderr."""
    assert BROWSER is not None
    command = [BROWSER, *OPTIONS, f"--user-data-dir={profile}", "--dump-dom", page.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)


def console_errors(log: str) -> list[str]:
    return [line for line in log.splitlines() if re.search(r"CONSOLE.*(Uncaught|Refused|Failed|net::)", line)]


def test_every_long_table_can_be_sorted(opened: subprocess.CompletedProcess[str]) -> None:
    tables = re.findall(r"<table.*?</table>", opened.stdout, re.DOTALL)
    long = [table for table in tables if table.partition("<tbody")[2].count("<tr") > 1]
    assert len(long) > 5
    for table in long:
        head = table.partition("</thead>")[0]
        assert head.count("<th ") == head.count("<button") > 0


def test_no_error_in_the_console(opened: subprocess.CompletedProcess[str], tmp_path: Path) -> None:
    assert console_errors(opened.stderr) == []
    broken = tmp_path / "broken.html"
    broken.write_text("<!doctype html><script>nothing_of_the_kind()</script>", encoding="utf-8")
    assert console_errors(opened_page(broken, tmp_path / "profile").stderr) != []
