"""``splinebba adjust``: the adjustment of a project, its results in a folder."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from splinebba_cli.commands.console import (
    Log,
    expected_errors,
    print_annotations,
    print_error_annotations,
    print_json,
    rich_console,
)
from splinebba_cli.commands.options import (
    CheckFormat,
    CheckFormatOption,
    DispersionChoice,
    OutlierChoice,
    ProjectArgument,
    QuietOption,
    TableChoice,
    VerboseOption,
)
from splinebba_cli.errors import ExitCode, SplinebbaError


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
    junit: Annotated[
        Path | None,
        typer.Option("--junit", help="JUnit XML to write: one test case a criterion of `acceptance`."),
    ] = None,
    format: CheckFormatOption = CheckFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Adjust a project and write its results: values, dispersion, tests, reports."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is CheckFormat.json), _reported(project, junit, format):
        from splinebba_cli.core.adjustment import adjust as adjust_network
        from splinebba_cli.output.result_folder import write_result_folder
        from splinebba_cli.project.acceptance import assess, violations
        from splinebba_cli.project.adjusted import adjusted_project
        from splinebba_cli.project.loading import load_project
        from splinebba_cli.project.overrides import with_outliers
        from splinebba_cli.report.build import write_reports
        from splinebba_cli.report.console import ConsoleSummary
        from splinebba_cli.report.result_data import ResultData

        start = time.perf_counter()
        loaded = load_project(project)
        if outliers is not None:
            loaded = with_outliers(loaded, outliers.value)
        log.warnings(loaded.diagnostics)
        read = time.perf_counter()
        full = dispersion is DispersionChoice.full
        result = adjust_network(loaded.network, observer=log.iteration, full_dispersion=full)
        criteria = assess(loaded.model.acceptance, result)
        failed = violations(criteria)
        result = replace(result, acceptance=criteria, problems=(*failed, *result.problems))
        adjusted = time.perf_counter()
        directory = output if output is not None else default_output(loaded.path)
        written = write_result_folder(
            directory,
            result,
            loaded=loaded,
            adjusted_files=adjusted_project(loaded, result, directory),
            dispersion=dispersion.value,
            tables=tables.value,
            reports=lambda folder, new: write_reports(
                folder, ResultData.of(new), ["text", "html"] if html else ["text"]
            ),
            timings={"read": read - start, "adjust": adjusted - read, **result.timings},
        )
        log.detail(f"read {read - start:.2f} s, adjusted {adjusted - read:.2f} s")
        if junit is not None:
            from splinebba_cli.output.junit import junit_of_criteria

            _write_junit(junit, junit_of_criteria(loaded.name, criteria))
        if format is CheckFormat.json:
            print_json(summary_data(written.content, directory, accepted=not failed))
        elif format is CheckFormat.github:
            print_annotations(loaded.path, result.problems)
        else:
            console = rich_console()
            console.print(ConsoleSummary(ResultData(written.content)))
            console.print(f"Results: {directory}", markup=False, soft_wrap=True)
    if failed:
        raise typer.Exit(ExitCode.NOT_ACCEPTED)


@contextmanager
def _reported(project: Path, junit: Path | None, format: CheckFormat) -> Iterator[None]:
    """An adjustment that ends without results is told to those who read JUnit files and annotations."""
    try:
        yield
    except SplinebbaError as error:
        if junit is not None:
            from splinebba_cli.output.junit import junit_of_error

            _write_junit(junit, junit_of_error(project.stem, error))
        if format is CheckFormat.github:
            print_error_annotations(project, error)
        raise


def _write_junit(path: Path, text: str) -> None:
    from splinebba_cli.output.atomic import write_file_atomically

    write_file_atomically(path, text)


def default_output(project: Path) -> Path:
    """``P.results`` beside ``P.yaml``."""
    return project.with_name(f"{project.stem}.results")


def summary_data(content: dict[str, Any], directory: Path, *, accepted: bool) -> dict[str, Any]:
    """What ``adjust --format json`` prints: the head of result.json and the verdict."""
    return {
        "results": str(directory),
        "accepted": accepted,
        "status": content["status"],
        "statistics": content["statistics"],
        "acceptance": content["acceptance"],
        "problems": content["problems"],
    }
