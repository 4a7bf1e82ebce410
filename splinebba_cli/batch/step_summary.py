"""A batch as Markdown, for the summary page of a workflow of GitHub Actions."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from splinebba_cli.batch.outcome import Outcome, Verdict, counted, worst_first
from splinebba_cli.project.diagnostics import Diagnostic
from splinebba_cli.report.markdown_text import markdown_prose
from splinebba_cli.write_errors import cannot_write

VARIABLE = "GITHUB_STEP_SUMMARY"
_PROBLEMS = 10  # of a project
_LARGEST = 900_000  # bytes: GitHub shows 1 MiB a step
_MARKS = {Verdict.accepted: "✅", Verdict.not_run: "⏭️", Verdict.not_accepted: "❌"}


def append_step_summary(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Append the summary to a file.

    Raises
    ------
    OutputError
        SBB601, SBB604, SBB605, SBB607, if the file cannot be written.
    """
    try:
        with path.open("a", encoding="utf-8", newline="\n") as stream:
            stream.write(step_summary(outcomes))
    except OSError as error:
        raise cannot_write(path, error) from error


def asked_for() -> Path | None:
    """The file that the environment asks for."""
    name = os.environ.get(VARIABLE, "")
    return Path(name) if name else None


def step_summary(outcomes: Sequence[Outcome]) -> str:
    """Table of all projects, the worst first, then the problems of those that are not accepted."""
    rows = worst_first(outcomes)
    lines = ["### Bundle block adjustments", "", _text(counted(outcomes)), ""]
    lines += [
        "| Project | Verdict | σ̂₀ | Redundancy | Errors | Warnings | Time |",
        "|---|---|--:|--:|--:|--:|--:|",
    ]
    lines += [_row(outcome) for outcome in rows]
    size = sum(len(line.encode()) for line in lines)
    for outcome in rows:
        part = _problems(outcome) if outcome.verdict is not Verdict.accepted and outcome.problems else []
        size += sum(len(line.encode()) + 1 for line in part)
        if size > _LARGEST:
            lines += ["", "More problems are in the log of the job."]
            break
        lines += part
    return "\n".join(lines) + "\n\n"


def _row(outcome: Outcome) -> str:
    sigma0, redundancy = (outcome.statistics.get(key) for key in ("sigma0", "redundancy"))
    cells = (
        _text(outcome.project),
        f"{_MARKS.get(outcome.verdict, '🛑')} {outcome.verdict.value}",
        "" if sigma0 is None else f"{sigma0:.4f}",
        "" if redundancy is None else str(redundancy),
        str(outcome.count("error") or ""),
        str(outcome.count("warning") or ""),
        "up to date" if outcome.up_to_date else f"{outcome.seconds:.1f} s",
    )
    return f"| {' | '.join(cells)} |"


def _problems(outcome: Outcome) -> list[str]:
    shown = [problem for problem in outcome.problems if problem.severity != "info"]
    lines = ["", f"<details><summary>{_text(outcome.project)}: {outcome.verdict.value}</summary>", ""]
    lines += [_item(problem) for problem in shown[:_PROBLEMS]]
    if len(shown) > _PROBLEMS:
        lines.append(f"- … and {len(shown) - _PROBLEMS} more")
    return [*lines, "", "</details>"]


def _item(problem: Diagnostic) -> str:
    where = f" ({_text(problem.position)})" if problem.position else ""
    help = f"<br>{_text(problem.help)}" if problem.help else ""
    return f"- **{problem.severity} {problem.code}** {_text(problem.message)}{where}{help}"


def _text(text: str) -> str:
    """Text of one or more lines, on one."""
    return markdown_prose(" ".join(text.split()))
