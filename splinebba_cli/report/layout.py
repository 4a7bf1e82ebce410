"""A report of any kind as text of a format."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from splinebba_cli.report.blocks import FigureBlock, Report

TextFormat = Literal["html", "text", "markdown", "json"]


def laid_out(report: Report, format: TextFormat, draw: Callable[[FigureBlock], str]) -> str:
    """A report as text.

    Parameters
    ----------
    draw : callable
        Gives the markup of a figure, for html; empty where there is nothing to draw.
    """
    if format == "html":
        from splinebba_cli.report.html import render_page

        return render_page(report, draw)
    if format == "markdown":
        from splinebba_cli.report.markdown import render_markdown

        return render_markdown(report)
    if format == "json":
        from splinebba_cli.report.json_report import render_json

        return render_json(report)
    from splinebba_cli.report.text import render_text

    return render_text(report)
