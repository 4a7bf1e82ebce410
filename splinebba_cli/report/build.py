"""A report from a result folder, so that it can be built again at any time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from splinebba_cli.output.atomic import write_file_atomically
from splinebba_cli.output.damaged_results import complete_results
from splinebba_cli.report.blocks import Report
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import build_report

ReportFormat = Literal["html", "text"]
_FILES: dict[ReportFormat, str] = {"html": "report.html", "text": "report.txt"}


def write_report(result_dir: Path, format: ReportFormat, out: Path | None = None) -> Path:
    """Build the report of a result folder and write it.

    Parameters
    ----------
    result_dir : Path
        A folder that ``adjust`` wrote: result.json and the tables beside it.
    format : {"html", "text"}
    out : Path, optional
        The file to write; by default ``report.html`` or ``report.txt`` in `result_dir`.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    OutputError
        SBB602 if it is no result folder, SBB601 if the file cannot be written.
    """
    path = out if out is not None else result_dir / _FILES[format]
    with complete_results(result_dir):
        data = ResultData.load(result_dir)
        text = _rendered(build_report(data), data, format)
    write_file_atomically(path, text)
    return path


def write_reports(folder: Path, data: ResultData, formats: Sequence[ReportFormat]) -> None:
    """Reports of a result folder in several formats, of data that are at hand."""
    report = build_report(data)
    for name in formats:
        write_file_atomically(folder / _FILES[name], _rendered(report, data, name))


def _rendered(report: Report, data: ResultData, format: ReportFormat) -> str:
    if format == "html":
        from splinebba_cli.report.html import render_html

        return render_html(report, data)
    from splinebba_cli.report.text import render_text

    return render_text(report)
