"""match.txt and match.html: the reports of a matching, and how they are made again from its folder."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.layout import TextFormat, laid_out
from splinebba_cli.report.match_drawings import read_drawings, write_drawings
from splinebba_cli.report.match_panels import Panel, panels_of
from splinebba_cli.report.match_sections import build_match_report

if TYPE_CHECKING:
    from splinebba_cli.core.matching.matches import MatchResult
    from splinebba_cli.report.blocks import FigureBlock

MATCH_REPORTS = {
    "html": "match.html",
    "text": "match.txt",
    "markdown": "match.md",
    "json": "match_report.json",
    "pdf": "match.pdf",
}


def write_match_reports(
    folder: Path, result: MatchResult, content: dict[str, Any], formats: Sequence[TextFormat]
) -> None:
    """Write reports, and what is drawn in them, into a folder that is being made.

    Parameters
    ----------
    content : dict
        Of match.json.
    """
    panels = panels_of(result, content["images"])
    write_drawings(folder, panels)
    for name in formats:
        text = match_report(content, panels, name)
        (folder / MATCH_REPORTS[name]).write_text(text, encoding="utf-8", newline="\n")


def stored_match_report(folder: Path, content: dict[str, Any], format: TextFormat) -> str:
    """The report of a folder that `match` wrote, as text.

    Raises
    ------
    OSError, ValueError, LookupError, TypeError
        If the drawings are missing or damaged.
    """
    return match_report(content, read_drawings(folder) if format == "html" else [], format)


def match_report(content: dict[str, Any], panels: list[Panel], format: TextFormat) -> str:
    """The report as text; the same content and drawings give the same text."""
    return laid_out(build_match_report(content), format, partial(_drawn, content=content, panels=panels))


def _drawn(block: FigureBlock, *, content: dict[str, Any], panels: list[Panel]) -> str:
    """The markup of a figure."""
    from splinebba_cli.report.match_figures import ambiguity, gate_history
    from splinebba_cli.report.match_panels_svg import match_images

    if block.figure == "match_images":
        return match_images(panels, content["images"], new=bool(content["new_splines"]))
    return {"gate_history": gate_history, "ambiguity": ambiguity}[block.figure](content)
