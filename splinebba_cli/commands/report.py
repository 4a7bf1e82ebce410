"""``splinebba report``: the report of a result folder, built again."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from splinebba_cli.commands.console import Log, expected_errors, print_json
from splinebba_cli.commands.options import QuietOption, ReportChoice, VerboseOption


def report(
    results: Annotated[
        Path,
        typer.Argument(
            metavar="RESULTS", help="Result folder that `adjust` or `match` wrote.", show_default=False
        ),
    ],
    format: Annotated[
        ReportChoice,
        typer.Option(
            "--format", help="Kind of report; pdf is printed by an installed Chromium, Chrome or Edge."
        ),
    ] = ReportChoice.html,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="File to write, - for standard output. Default: report.html, report.txt, … in RESULTS "
            "(match.html, … in one of `match`), standard output for json.",
        ),
    ] = None,
    browser: Annotated[
        str | None,
        typer.Option(
            "--browser",
            metavar="PROGRAM",
            help="Browser that prints the pdf. Default: SPLINEBBA_BROWSER, or the first that is found.",
        ),
    ] = None,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Build the report of a result folder again."""
    log, as_json = Log(quiet, verbose), format is ReportChoice.json
    with expected_errors(as_json=as_json):
        from splinebba_cli.report.build import report_of, write_report

        if output == Path("-") or (as_json and output is None):
            with log.working():
                content = report_of(results, format.value, browser)
            sys.stdout.buffer.write(content.encode("utf-8") if isinstance(content, str) else content)
            sys.stdout.flush()
        else:
            with log.working():
                path = write_report(results, format.value, output, browser)
            if as_json:
                print_json({"report": str(path), "problems": []})
            else:
                print(path)
        log.finished()
