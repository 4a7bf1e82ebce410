"""``splinebba adjust``: the adjustment of a project, its results in a folder."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
    DispersionOption,
    HtmlOption,
    OutliersOption,
    ProjectArgument,
    QuietOption,
    TableChoice,
    TablesOption,
    VerboseOption,
)
from splinebba_cli.commands.places import require_place
from splinebba_cli.errors import ExitCode, SplinebbaError

if TYPE_CHECKING:
    from splinebba_cli.jobs.adjust_job import AdjustOutcome


def adjust(
    project: ProjectArgument,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="FOLDER",
            help="Result folder; replaced as a whole. Default: PROJECT.results beside it.",
        ),
    ] = None,
    dispersion: DispersionOption = DispersionChoice.blocks,
    tables: TablesOption = TableChoice.csv,
    outliers: OutliersOption = None,
    html: HtmlOption = True,
    junit: Annotated[
        Path | None,
        typer.Option(
            "--junit", metavar="FILE", help="JUnit XML to write: one test case a criterion of `acceptance`."
        ),
    ] = None,
    format: CheckFormatOption = CheckFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Adjust a project and write its results: values, dispersion, tests, reports."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is CheckFormat.json):
        require_place(junit)
    with expected_errors(as_json=format is CheckFormat.json), _reported(project, junit, format):
        from splinebba_cli.jobs.adjust_job import AdjustOptions, run_adjustment

        options = AdjustOptions(
            output, dispersion.value, tables.value, None if outliers is None else outliers.value, html
        )
        with log.working():
            done = run_adjustment(project, options, warned=log.warnings, iterated=log.iteration)
        log.detail(sizes_text(done.content["statistics"]))
        log.finished(done.seconds)
        if junit is not None:
            from splinebba_cli.output.junit import junit_of_criteria

            _write_junit(junit, junit_of_criteria(done.loaded.name, done.criteria))
        if format is CheckFormat.json:
            print_json(summary_data(done))
        elif format is CheckFormat.github:
            print_annotations(done.loaded.path, done.problems)
        else:
            _print_summary(done)
    if not done.accepted:
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


def _print_summary(done: AdjustOutcome) -> None:
    from splinebba_cli.report.console import ConsoleSummary
    from splinebba_cli.report.result_data import ResultData

    console = rich_console()
    console.print(ConsoleSummary(ResultData(done.content)))
    console.print(f"Results: {done.directory}", markup=False, soft_wrap=True)


def sizes_text(statistics: dict[str, Any]) -> str:
    """How large an adjustment was."""
    counts = ", ".join(f"{statistics[name]} {name}" for name in ("observations", "unknowns", "conditions"))
    return f"size: {counts}, redundancy {statistics['redundancy']}"


def summary_data(done: AdjustOutcome) -> dict[str, Any]:
    """What ``adjust --format json`` prints: the head of result.json, the verdict, and all that was found."""
    from splinebba_cli.project.diagnostics import as_json_data

    content = done.content
    return {
        "results": str(done.directory),
        "accepted": done.accepted,
        "status": content["status"],
        "statistics": content["statistics"],
        "acceptance": content["acceptance"],
        "problems": [*as_json_data(done.loaded.diagnostics), *content["problems"]],
    }
