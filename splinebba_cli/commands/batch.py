"""``splinebba batch``: many projects in one run."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from splinebba_cli.commands.console import Log, expected_errors
from splinebba_cli.commands.options import (
    CheckFormat,
    CheckFormatOption,
    DispersionChoice,
    OutlierChoice,
    QuietOption,
    TableChoice,
    VerboseOption,
)
from splinebba_cli.errors import OutputError

_LONGEST_S = 4_000_000.0  # clocks of some systems end after 49 days


def batch(
    targets: Annotated[
        list[str],
        typer.Argument(
            metavar="TARGET",
            help="Project files, folders with a project.yaml, patterns such as 'blocks/**/project.yaml'.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="DIR",
            help="One folder for all results, with the folders of the projects inside. Default: beside each.",
        ),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            "--jobs",
            "-j",
            metavar="N",
            min=1,
            help="Worker processes. Default: one a core.",
            show_default=False,
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            help="Scheduler of dask.distributed (tcp://host:8786) whose workers adjust.",
        ),
    ] = None,
    timeout: Annotated[
        float | None,
        typer.Option(
            "--timeout", metavar="SECONDS", min=0.001, max=_LONGEST_S, help="Longest time for a project."
        ),
    ] = None,
    fail_fast: Annotated[
        bool, typer.Option("--fail-fast", help="Stop at the first project that is not accepted.")
    ] = False,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume", help="Keep results of the same program, options and files; adjust the others."
        ),
    ] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="List projects and result folders; adjust nothing.")
    ] = False,
    junit: Annotated[
        Path | None,
        typer.Option(
            "--junit", metavar="FILE", help="JUnit XML to write: a suite a project, a case a criterion."
        ),
    ] = None,
    step_summary: Annotated[
        Path | None,
        typer.Option(
            "--step-summary",
            metavar="FILE",
            help="File to append a summary in Markdown to. Default: $GITHUB_STEP_SUMMARY where that is set.",
            show_default=False,
        ),
    ] = None,
    log: Annotated[
        Path | None,
        typer.Option(
            "--log", metavar="FILE", help="Log to write: a line of JSON a project, as soon as it is finished."
        ),
    ] = None,
    dispersion: Annotated[
        DispersionChoice, typer.Option("--dispersion", help="How much of the dispersion matrices is kept.")
    ] = DispersionChoice.blocks,
    tables: Annotated[
        TableChoice, typer.Option("--tables", help="Format of the result tables.")
    ] = TableChoice.csv,
    outliers: Annotated[
        OutlierChoice | None,
        typer.Option("--outliers", help="What is done with gross errors; default: as each project says."),
    ] = None,
    html: Annotated[bool, typer.Option("--html/--no-html", help="Whether report.html is written.")] = True,
    format: CheckFormatOption = CheckFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Adjust many projects side by side; one table, one exit code: the worst."""
    with expected_errors(as_json=format is CheckFormat.json):
        from splinebba_cli.batch.plan import plan
        from splinebba_cli.batch.step_summary import asked_for
        from splinebba_cli.batch.targets import find_projects
        from splinebba_cli.commands.batch_run import Places, Request, list_tasks, run_and_tell
        from splinebba_cli.jobs.adjust_job import AdjustOptions

        options = AdjustOptions(
            output, dispersion.value, tables.value, None if outliers is None else outliers.value, html
        )
        begin = time.perf_counter()
        tasks = plan(find_projects(targets), options)
        request = Request(jobs, scheduler, timeout, fail_fast, resume)
        if dry_run:
            list_tasks(tasks, request, format)
            return
        places = Places(junit, step_summary or asked_for(), log)
        for place in (junit, step_summary, log):
            _require_folder(place)
        run_and_tell(tasks, request, places, Log(quiet, verbose), format, begin)


def _require_folder(place: Path | None) -> None:
    """What cannot be written at the end is said before the batch begins."""
    if place is not None and not place.parent.is_dir():
        help = "make the folder first, or choose another one"
        raise OutputError("SBB601", f"cannot write {place}: there is no folder `{place.parent}`", help)
