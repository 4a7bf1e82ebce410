"""``splinebba batch``: many projects in one run."""

from __future__ import annotations

import time

from splinebba_cli.commands import batch_options as option
from splinebba_cli.commands.console import Log, expected_errors
from splinebba_cli.commands.options import (
    CheckFormat,
    CheckFormatOption,
    DispersionChoice,
    DispersionOption,
    HtmlOption,
    OutliersOption,
    QuietOption,
    TableChoice,
    TablesOption,
    VerboseOption,
)
from splinebba_cli.commands.places import require_place


def batch(
    targets: option.TargetsArgument,
    output: option.FolderOption = None,
    jobs: option.JobsOption = None,
    scheduler: option.SchedulerOption = None,
    timeout: option.TimeoutOption = None,
    fail_fast: option.FailFastOption = False,
    resume: option.ResumeOption = False,
    dry_run: option.DryRunOption = False,
    junit: option.JunitOption = None,
    step_summary: option.StepSummaryOption = None,
    log: option.LogOption = None,
    dispersion: DispersionOption = DispersionChoice.blocks,
    tables: TablesOption = TableChoice.csv,
    outliers: OutliersOption = None,
    html: HtmlOption = True,
    match: option.MatchOption = False,
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
            output, dispersion.value, tables.value, None if outliers is None else outliers.value, html, match
        )
        begin = time.perf_counter()
        tasks = plan(find_projects(targets), options)
        request = Request(jobs, scheduler, timeout, fail_fast, resume)
        if dry_run:
            list_tasks(tasks, request, format)
            return
        places = Places(junit, step_summary or asked_for(), log)
        for place in (junit, step_summary, log):
            require_place(place)
        run_and_tell(tasks, request, places, Log(quiet, verbose), format, begin)
