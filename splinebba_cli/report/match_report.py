"""match.txt and match.html: the reports of a matching."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from splinebba_cli.report.match_sections import build_match_report
from splinebba_cli.report.text import render_text

if TYPE_CHECKING:
    from splinebba_cli.core.matching.matches import MatchResult
    from splinebba_cli.report.blocks import FigureBlock, Report

MatchReportFormat = Literal["text", "html"]
_FILES: dict[MatchReportFormat, str] = {"text": "match.txt", "html": "match.html"}


def write_match_reports(
    folder: Path, result: MatchResult, content: dict[str, Any], formats: Sequence[MatchReportFormat]
) -> None:
    """Write reports into a folder that is being made.

    Parameters
    ----------
    content : dict
        Of match.json.
    formats : sequence of {"text", "html"}
    """
    report = build_match_report(content)
    for name in formats:
        text = render_text(report) if name == "text" else _page(report, result, content)
        (folder / _FILES[name]).write_text(text, encoding="utf-8", newline="\n")


def _page(report: Report, result: MatchResult, content: dict[str, Any]) -> str:
    from splinebba_cli.report.html import render_page

    return render_page(report, partial(_drawn, result=result, content=content))


def _drawn(block: FigureBlock, *, result: MatchResult, content: dict[str, Any]) -> str:
    """The markup of a figure."""
    from splinebba_cli.report.match_figures import ambiguity, gate_history
    from splinebba_cli.report.match_panels import match_images

    if block.figure == "match_images":
        return match_images(result, content["images"])
    return {"gate_history": gate_history, "ambiguity": ambiguity}[block.figure](content)
