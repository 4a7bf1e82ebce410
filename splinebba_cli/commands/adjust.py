"""``splinebba adjust``: the adjustment of a project, its results in a folder."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from splinebba_cli.commands.console import (
    Log,
    expected_errors,
    print_json,
    rich_console,
)
from splinebba_cli.commands.options import (
    DispersionChoice,
    FormatOption,
    OutlierChoice,
    OutputFormat,
    ProjectArgument,
    QuietOption,
    TableChoice,
    VerboseOption,
)
from splinebba_cli.errors import ExitCode

if TYPE_CHECKING:
    from splinebba_cli.core.result import AdjustmentResult


def adjust(
    project: ProjectArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Result folder; replaced as a whole. Default: PROJECT.results beside it."
        ),
    ] = None,
    dispersion: Annotated[
        DispersionChoice, typer.Option("--dispersion", help="How much of the dispersion matrix is kept.")
    ] = DispersionChoice.blocks,
    tables: Annotated[
        TableChoice, typer.Option("--tables", help="Format of the result tables.")
    ] = TableChoice.csv,
    outliers: Annotated[
        OutlierChoice | None,
        typer.Option("--outliers", help="What is done with gross errors; default: as the project says."),
    ] = None,
    html: Annotated[bool, typer.Option("--html/--no-html", help="Whether report.html is written.")] = True,
    format: FormatOption = OutputFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Adjust a project and write its results: values, dispersion, tests, reports."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is OutputFormat.json):
        from splinebba_cli.core.adjustment import adjust as adjust_network
        from splinebba_cli.output.result_folder import write_result_folder
        from splinebba_cli.project.acceptance import violations
        from splinebba_cli.project.adjusted import adjusted_project
        from splinebba_cli.project.loading import load_project
        from splinebba_cli.project.overrides import with_outliers
        from splinebba_cli.report.build import write_reports

        start = time.perf_counter()
        loaded = load_project(project)
        if outliers is not None:
            loaded = with_outliers(loaded, outliers.value)
        log.warnings(loaded.diagnostics)
        read = time.perf_counter()
        full = dispersion is DispersionChoice.full
        result = adjust_network(loaded.network, observer=log.iteration, full_dispersion=full)
        failed = violations(loaded.model.acceptance, result)
        result = replace(result, problems=(*failed, *result.problems))
        adjusted = time.perf_counter()
        directory = output if output is not None else default_output(loaded.path)
        write_result_folder(
            directory,
            result,
            loaded=loaded,
            adjusted_files=adjusted_project(loaded, result, directory),
            dispersion=dispersion.value,
            tables=tables.value,
            reports=lambda folder: write_reports(folder, ["text", "html"] if html else ["text"]),
            timings={"read": read - start, "adjust": adjusted - read, **result.timings},
        )
        log.detail(f"read {read - start:.2f} s, adjusted {adjusted - read:.2f} s")
        if format is OutputFormat.json:
            print_json(summary_data(result, directory, accepted=not failed))
        else:
            _print_summary(result, directory)
    if failed:
        raise typer.Exit(ExitCode.NOT_ACCEPTED)


def default_output(project: Path) -> Path:
    """``P.results`` beside ``P.yaml``."""
    return project.with_name(f"{project.stem}.results")


def summary_data(result: AdjustmentResult, directory: Path, *, accepted: bool) -> dict[str, Any]:
    """What ``adjust --format json`` prints: the head of result.json and the verdict."""
    from splinebba_cli.output.result_json import result_to_dict

    content = result_to_dict(result)
    return {
        "results": str(directory),
        "accepted": accepted,
        "status": content["status"],
        "statistics": content["statistics"],
        "problems": content["problems"],
    }


def _print_summary(result: AdjustmentResult, directory: Path) -> None:
    from splinebba_cli.report.console import console_summary

    console = rich_console()
    console.print(console_summary(result))
    console.print(f"Results: {directory}", markup=False, soft_wrap=True)
