"""A report from a result folder, so that it can be built again at any time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from splinebba_cli.output.atomic import write_file_atomically
from splinebba_cli.output.damaged_results import complete_results
from splinebba_cli.output.match_folder import is_match_folder
from splinebba_cli.output.match_json import load_match_json
from splinebba_cli.report.blocks import FigureBlock, Report
from splinebba_cli.report.layout import TextFormat, laid_out
from splinebba_cli.report.match_report import MATCH_REPORTS, stored_match_report
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report

ReportFormat = Literal["html", "text", "markdown", "json", "pdf"]
_FILES: dict[ReportFormat, str] = {
    "html": "report.html",
    "text": "report.txt",
    "markdown": "report.md",
    "json": "report.json",
    "pdf": "report.pdf",
}


def write_report(
    result_dir: Path, format: ReportFormat, out: Path | None = None, browser: str | None = None
) -> Path:
    """Build the report of a result folder and write it.

    Parameters
    ----------
    result_dir : Path
        A folder that ``adjust`` wrote: result.json and the tables beside it; or one that ``match`` wrote.
    format : {"html", "text", "markdown", "json", "pdf"}
    out : Path, optional
        The file to write; by default ``report.html``, ``report.txt``, … in `result_dir`; ``match.html``, … in one of
        ``match``.
    browser : str, optional
        The program that prints a PDF, see :func:`splinebba_cli.report.browser.browser_path`.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    OutputError
        SBB602 if it is no result folder, SBB601 if the file cannot be written, SBB620 and SBB621 if a PDF
        cannot be made.
    """
    names = MATCH_REPORTS if is_match_folder(result_dir) else _FILES
    path = out if out is not None else result_dir / names[format]
    write_file_atomically(path, report_of(result_dir, format, browser))
    return path


def report_of(result_dir: Path, format: ReportFormat, browser: str | None = None) -> str | bytes:
    """The report of a result folder: text, or the bytes of a PDF; arguments and errors of :func:`write_report`."""
    with complete_results(result_dir):
        wanted: TextFormat = "html" if format == "pdf" else format
        if is_match_folder(result_dir):
            data = ResultData(load_match_json(result_dir))
            text = stored_match_report(result_dir, data.content, wanted)
        else:
            data = ResultData.load(result_dir)
            text = rendered(build_report(data), data, wanted)
    if format != "pdf":
        return text
    from splinebba_cli.report.browser import print_to_pdf
    from splinebba_cli.report.pdf import dated_pdf

    return dated_pdf(print_to_pdf(text, browser), data)


def write_reports(folder: Path, data: ResultData, formats: Sequence[TextFormat]) -> None:
    """Reports in several formats, of data that are at hand, in a result folder that is being made."""
    report = build_report(data)
    for name in formats:
        (folder / _FILES[name]).write_text(rendered(report, data, name), encoding="utf-8", newline="\n")


def rendered(report: Report, data: ResultData, format: TextFormat) -> str:
    """A report as text of a format; the same report and data give the same text."""

    def drawn(block: FigureBlock) -> str:
        from splinebba_cli.report.figures import draw

        return draw(block, data=data)

    return laid_out(report, format, drawn)
