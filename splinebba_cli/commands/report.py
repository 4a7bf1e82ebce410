"""``splinebba report``: the report of a result folder, built again."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from splinebba_cli.commands.console import expected_errors
from splinebba_cli.commands.options import ReportChoice


def report(
    results: Annotated[
        Path, typer.Argument(metavar="RESULTS", help="Result folder that `adjust` wrote.", show_default=False)
    ],
    format: Annotated[ReportChoice, typer.Option("--format", help="Kind of report.")] = ReportChoice.html,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="File to write. Default: report.html or report.txt in RESULTS."),
    ] = None,
) -> None:
    """Build the report of a result folder."""
    with expected_errors():
        from splinebba_cli.report.build import write_report

        print(write_report(results, format.value, output))
