"""What ``splinebba batch`` does with its projects, and whom it tells."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.batch.outcome import Outcome, Verdict, counted, exit_code, worst_first
from splinebba_cli.batch.run import BatchResult, run_batch
from splinebba_cli.batch.summary_table import STYLES, BatchSummary
from splinebba_cli.batch.up_to_date import kept_outcomes
from splinebba_cli.commands.console import Log, print_json, rich_console
from splinebba_cli.commands.options import CheckFormat
from splinebba_cli.commands.streams import is_terminal, live_console

if TYPE_CHECKING:
    from rich.progress import Progress

    from splinebba_cli.batch.plan import Task

BATCH_FORMAT = "splinebba-batch/1"
_WIDTH_OF_FILES = 500  # logs of CI systems wrap lines themselves


@dataclass(frozen=True)
class Request:
    """What the options ask for."""

    jobs: int | None
    scheduler: str | None
    timeout: float | None
    fail_fast: bool
    resume: bool


@dataclass(frozen=True)
class Places:
    """Files for those who read JUnit, summaries of steps, logs."""

    junit: Path | None
    step_summary: Path | None
    log: Path | None


def list_tasks(tasks: Sequence[Task], request: Request, format: CheckFormat) -> None:
    """What would be adjusted, and where its results would go."""
    kept = _kept(tasks, request)
    if format is CheckFormat.json:
        rows = zip(tasks, kept, strict=True)
        print_json(
            [
                {
                    "project": str(task.project),
                    "results": str(task.results),
                    "up_to_date": outcome is not None,
                }
                for task, outcome in rows
            ]
        )
        return
    for task, outcome in zip(tasks, kept, strict=True):
        print(f"{task.project} -> {task.results}{' (up to date)' if outcome else ''}")


def run_and_tell(
    tasks: Sequence[Task], request: Request, places: Places, log: Log, format: CheckFormat, begin: float
) -> None:
    """Adjust; then print the summary, write the files, and exit with the worst code."""
    with _told(tasks, request, places, log) as tell:
        kept = partial(_kept, request=request)
        result = run_batch(tasks, kept, _adjust(request), fail_fast=request.fail_fast, tell=tell)
    log.detail(f"{counted(result.outcomes)} in {time.perf_counter() - begin:.1f} s")
    code = _code(result)
    _print(result, code, format, log)
    _write_files(result, places)
    if result.interruption:
        done = sum(outcome.verdict is not Verdict.not_run for outcome in result.outcomes)
        log.say(f"interrupted; {done} of {len(tasks)} projects are done, --resume goes on")
    if code:
        raise typer.Exit(code)


def _kept(tasks: Sequence[Task], request: Request) -> Sequence[Outcome | None]:
    return kept_outcomes(tasks) if request.resume else [None] * len(tasks)


def _adjust(request: Request) -> Callable[[Sequence[Task]], Generator[Outcome, None, None]]:
    """Who adjusts: processes of this machine, or a cluster."""
    if request.scheduler is not None:
        from splinebba_cli.batch.cluster import adjust_on_cluster

        return partial(adjust_on_cluster, address=request.scheduler, timeout=request.timeout)
    from splinebba_cli.batch.worker_pool import adjust_locally
    from splinebba_cli.simulation.executors import available_processors

    return partial(adjust_locally, jobs=request.jobs or available_processors(), timeout=request.timeout)


def _code(result: BatchResult) -> int:
    return result.interruption.exit_code if result.interruption else exit_code(result.outcomes)


@contextmanager
def _told(
    tasks: Sequence[Task], request: Request, places: Places, log: Log
) -> Iterator[Callable[[Outcome], None]]:
    """Progress and log file; gives what to call with every outcome."""
    from splinebba_cli.batch.log import BatchLog

    about = {**asdict(request), "projects": len(tasks), "options": tasks[0].options.told()}
    book = BatchLog(places.log, about) if places.log is not None else None
    known: list[Outcome] = []
    with _progress(len(tasks), log) as show:

        def tell(outcome: Outcome) -> None:
            known.append(outcome)
            if book is not None:
                book.add(outcome)
            show(outcome, len(known))

        try:
            yield tell
        finally:
            if book is not None:
                book.close(
                    {"finished": len(known), "not_run": len(tasks) - len(known), "summary": counted(known)}
                )


@contextmanager
def _progress(total: int, log: Log) -> Iterator[Callable[[Outcome, int], None]]:
    """A bar on stderr where that is a terminal, else a line a project."""
    width = len(str(total))

    def line(outcome: Outcome, number: int) -> None:
        log.say(f"[{number:{width}d}/{total}] {_said(outcome)}")

    if log.quiet or not is_terminal(sys.stderr):
        yield line
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("projects"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=live_console(), transient=True) as bar:
        yield partial(_advance, bar, bar.add_task("projects", total=total), bool(log.verbose))


def _advance(bar: Progress, task: Any, every: bool, outcome: Outcome, _: int) -> None:
    """Move the bar; above it stand the projects that are not accepted, or all."""
    from rich.text import Text

    if every or outcome.verdict is not Verdict.accepted:
        bar.console.print(Text(_said(outcome), STYLES.get(outcome.verdict, "red")), soft_wrap=True)
    bar.advance(task)


def _said(outcome: Outcome) -> str:
    sigma0 = outcome.statistics.get("sigma0")
    parts = [outcome.verdict.value, *([] if sigma0 is None else [f"σ̂₀ {sigma0:.4f}"])]
    parts.append("up to date" if outcome.up_to_date else f"{outcome.seconds:.1f} s")
    return f"{outcome.project}: {', '.join(parts)}"


def _print(result: BatchResult, code: int, format: CheckFormat, log: Log) -> None:
    if format is CheckFormat.json:
        data = [outcome.data() for outcome in result.outcomes]
        head = {"format": BATCH_FORMAT, "exit_code": code, "interrupted": result.interruption is not None}
        print_json({**head, "summary": counted(result.outcomes), "projects": data})
    elif format is CheckFormat.github:
        _print_annotations(result.outcomes)
    else:
        console = rich_console()
        if not is_terminal(sys.stdout):
            console.width = _WIDTH_OF_FILES
        console.print(BatchSummary(result.outcomes, all_problems=bool(log.verbose) and not log.quiet))


def _print_annotations(outcomes: Sequence[Outcome]) -> None:
    """Errors and warnings, those of the worst projects first: GitHub shows ten of each kind a step."""
    from splinebba_cli.project.diagnostics import render_github

    problems = [problem for outcome in worst_first(outcomes) for problem in outcome.problems]
    shown = [problem for problem in problems if problem.severity != "info"]
    if shown:
        print(render_github(shown))
    print(counted(outcomes))


def _write_files(result: BatchResult, places: Places) -> None:
    if places.junit is not None:
        from splinebba_cli.batch.junit import junit_of_batch
        from splinebba_cli.output.atomic import write_file_atomically

        write_file_atomically(places.junit, junit_of_batch(result.outcomes))
    if places.step_summary is not None:
        from splinebba_cli.batch.step_summary import append_step_summary

        append_step_summary(places.step_summary, result.outcomes)
