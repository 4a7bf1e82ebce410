"""A browser of this machine that prints pages: Chromium, Chrome, Edge and their kin."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from splinebba_cli.errors import OutputError

VARIABLE = "SPLINEBBA_BROWSER"
_NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "microsoft-edge-stable",
    "msedge",
    "brave-browser",
)
_ELSEWHERE = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
    "win32": (
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
        r"C:\Program Files\Microsoft\Edge\Application\msedge.exe",
    ),
}
_SECONDS = 300
_OPTIONS = (
    "--headless",
    "--disable-gpu",
    "--disable-extensions",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--no-default-browser-check",
    "--no-pdf-header-footer",
    "--generate-pdf-document-outline",
)


def browser_path(chosen: str | None = None) -> str | None:
    """The browser that was chosen, or the first of this machine.

    Parameters
    ----------
    chosen : str, optional
        Program, by its name or path; by default that of the environment variable ``SPLINEBBA_BROWSER``.

    Returns
    -------
    str or None
        Path of the program; None: none was found.
    """
    chosen = chosen or os.environ.get(VARIABLE)
    if chosen:
        return shutil.which(chosen)
    return next(filter(None, map(shutil.which, (*_NAMES, *_ELSEWHERE.get(sys.platform, ())))), None)


def print_to_pdf(html: str, chosen: str | None = None) -> bytes:
    """What a browser prints of a page, as the bytes of a PDF.

    Parameters
    ----------
    html : str
        A page that needs nothing from elsewhere.
    chosen : str, optional
        As of :func:`browser_path`.

    Raises
    ------
    OutputError
        SBB620 if there is no browser, SBB621 if it makes no PDF.
    """
    program = browser_path(chosen)
    if program is None:
        raise _no_browser(chosen or os.environ.get(VARIABLE))
    with tempfile.TemporaryDirectory(prefix="splinebba-pdf-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        page, pdf = folder / "report.html", folder / "report.pdf"
        page.write_text(html, encoding="utf-8")
        command = [program, *_OPTIONS, f"--user-data-dir={folder / 'profile'}", f"--print-to-pdf={pdf}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.append("--no-sandbox")  # Chromium refuses to start for root with its sandbox
        _run([*command, page.as_uri()])
        if not pdf.is_file() or not pdf.stat().st_size:
            raise OutputError("SBB621", f"{program} made no PDF of the report", _PRINT_YOURSELF)
        return pdf.read_bytes()


_PRINT_YOURSELF = (
    "open report.html in a browser and print it into a file; or name another browser with --browser"
)


def _no_browser(chosen: str | None) -> OutputError:
    if chosen:
        message = f"no program `{chosen}` was found to print the report"
    else:
        message = "a PDF is printed by Chromium, Chrome or Edge, and none was found on this machine"
    help = f"install one, or name one with --browser or {VARIABLE}; report.html prints well from any browser"
    return OutputError("SBB620", message, help)


def _run(command: list[str]) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=_SECONDS)
    except subprocess.TimeoutExpired:
        message = f"{command[0]} did not print the report within {_SECONDS} s"
        raise OutputError("SBB621", message, _PRINT_YOURSELF) from None
    except OSError as error:
        message = f"{command[0]} cannot be started: {error.strerror or error}"
        raise OutputError("SBB621", message, _PRINT_YOURSELF) from error
    if done.returncode:
        last = next((line for line in reversed(done.stderr.splitlines()) if line.strip()), "")
        reason = f": {last.strip()}" if last else ""
        message = f"{command[0]} ended with code {done.returncode} instead of a PDF{reason}"
        raise OutputError("SBB621", message, _PRINT_YOURSELF)
