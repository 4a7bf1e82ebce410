"""``splinebba report``: the report of a result folder, built again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from splinebba_cli.commands.console import Log, expected_errors, print_json
from splinebba_cli.commands.options import QuietOption, ReportChoice, VerboseOption


def report(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="Result folder that `adjust` wrote.", show_default=False)
    ],
    format: Annotated[
        ReportChoice,
        typer.Option(
            "--format",
            help="Kind of report; json: the kind by the name of the file, and what was written as JSON on stdout.",
        ),
    ] = ReportChoice.html,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="File to write. Default: report.html or report.txt in RESULTS.",
        ),
    ] = None,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Build the report of a result folder again."""
    log, as_json = Log(quiet, verbose), format is ReportChoice.json
    with expected_errors(as_json=as_json):
        from splinebba_cli.report.build import write_report

        kind = _kind(format, output)
        with log.working():
            written = write_report(results, kind, output)
        log.finished()
        if as_json:
            print_json({"report": str(written), "kind": kind, "problems": []})
        else:
            print(written)


def _kind(format: ReportChoice, output: Path | None) -> Literal["html", "text"]:
    """The kind of report: as asked for, else by the name of the file."""
    by_name = output is not None and output.suffix.lower() in (".txt", ".text")
    return "text" if format is ReportChoice.text or (format is ReportChoice.json and by_name) else "html"
