"""One task of a batch, done in this process: the adjustment and what became of it."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.batch.plan import Task
from splinebba_cli.core.result import Problem
from splinebba_cli.errors import NotSolvableError, OutputError, ProjectError, SplinebbaError
from splinebba_cli.jobs.adjust_job import run_adjustment
from splinebba_cli.jobs.match_job import MatchOutcome
from splinebba_cli.jobs.matched_adjust_job import run_matched_adjustment
from splinebba_cli.project.annotations import problem_diagnostics
from splinebba_cli.project.diagnostics import Diagnostic


def adjust_task(task: Task) -> Outcome:
    """Adjust a project and write its results.

    Expected errors become the outcome; others are raised: they are errors of the program.
    """
    begin = time.perf_counter()
    warnings: list[Diagnostic] = []
    try:
        outcome = _run(task, warnings)
    except SplinebbaError as error:
        problems = as_shown(task, [*warnings, *_diagnostics(task, error)])
        outcome = Outcome(str(task.project), _verdict(error), problems=problems)
    except MemoryError:
        outcome = outcome_of_loss(task, Verdict.killed, "the memory was not enough")
    return replace(outcome, seconds=round(time.perf_counter() - begin, 3))


def _run(task: Task, warnings: list[Diagnostic]) -> Outcome:
    """Adjust, after matching where that is asked for; `warnings` gets those of the project."""
    if not task.options.match:
        options = replace(task.options, output=task.result_folder)
        done = run_adjustment(task.project_file, options, warned=warnings.extend)
        return outcome_of_result(task, done.content, warnings)
    found = run_matched_adjustment(
        task.project_file, task.options, results=task.result_folder, warned=warnings.extend
    )
    if isinstance(found, MatchOutcome):
        return outcome_of_matching(task, found.content, warnings)
    return outcome_of_result(task, found.content, warnings)


def outcome_of_matching(task: Task, content: dict[str, Any], warnings: Sequence[Diagnostic] = ()) -> Outcome:
    """The outcome of a project of which too little was matched to be adjusted; content of match.json."""
    failed = [Problem("SBB510", "error", each["message"], "matching") for each in content["acceptance"]]
    found = problem_diagnostics(
        task.project_file, [*failed, *(Problem(**one) for one in content["problems"])]
    )
    return Outcome(
        str(task.project),
        Verdict.not_accepted,
        name=content["provenance"]["project"]["name"],
        results=str(task.matched),
        acceptance=content["acceptance"],
        problems=as_shown(task, [*warnings, *found]),
    )


def outcome_of_result(task: Task, content: dict[str, Any], warnings: Sequence[Diagnostic] = ()) -> Outcome:
    """The outcome that the content of result.json tells.

    Parameters
    ----------
    task : Task
    content : dict
        Of result.json.
    warnings : sequence of Diagnostic
        Of the project file.
    """
    found = problem_diagnostics(task.project_file, [Problem(**problem) for problem in content["problems"]])
    accepted = all(criterion["status"] == "passed" for criterion in content["acceptance"])
    return Outcome(
        str(task.project),
        Verdict.accepted if accepted else Verdict.not_accepted,
        name=content["provenance"]["project"]["name"],
        results=str(task.results),
        statistics=content["statistics"],
        acceptance=content["acceptance"],
        problems=as_shown(task, [*warnings, *found]),
    )


def outcome_of_loss(task: Task, verdict: Verdict, message: str, details: str = "") -> Outcome:
    """The outcome of a project whose worker ended before it had one."""
    codes = {Verdict.timed_out: "SBB802", Verdict.killed: "SBB801", Verdict.crashed: "SBB970"}
    helps = {
        Verdict.timed_out: "allow more with --timeout, or see with `splinebba adjust` what takes so long",
        Verdict.killed: "most often memory ran out: fewer --jobs, --dispersion none, or a machine with more of it",
        Verdict.crashed: f"this is a bug; `splinebba adjust {task.project}` writes a file to report it with",
    }
    problem = Diagnostic(codes[verdict], "error", message, helps[verdict], str(task.project))
    return Outcome(str(task.project), verdict, problems=(problem,), details=details)


def as_shown(task: Task, problems: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Problems whose files are named as the user sees them."""
    real, shown = task.project_file.parent, task.project.parent
    return tuple(
        replace(item, file=str(shown / Path(item.file).relative_to(real)))
        if item.file and Path(item.file).is_relative_to(real)
        else item
        for item in problems
    )


def _verdict(error: SplinebbaError) -> Verdict:
    if isinstance(error, NotSolvableError):
        return Verdict.not_solvable
    return Verdict.not_written if isinstance(error, OutputError) else Verdict.invalid


def _diagnostics(task: Task, error: SplinebbaError) -> Sequence[Diagnostic]:
    if isinstance(error, ProjectError):
        return error.diagnostics
    problems = error.problems if isinstance(error, NotSolvableError) else ()
    return problem_diagnostics(
        task.project_file, problems or [Problem(error.code, "error", error.message, "", error.help)]
    )
