"""What goes to the terminal: results to stdout; log, progress and errors to stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.commands.streams import print_json as print_json
from splinebba_cli.commands.streams import rich_console as rich_console
from splinebba_cli.errors import NotSolvableError, ProjectError, SplinebbaError

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console as RichConsole

    from splinebba_cli.commands.progress import PlainProgress
    from splinebba_cli.core.result import Iteration, Problem
    from splinebba_cli.interruption import InterruptedRunError
    from splinebba_cli.project.diagnostics import Diagnostic


class Log:
    """Messages and progress on stderr.

    Parameters
    ----------
    quiet : bool
        -q: nothing at all; errors are printed by others.
    verbose : int
        1: times, sizes and memory, every iteration; 2: damping, ordering and the like as well.
    """

    def __init__(self, quiet: bool = False, verbose: int = 0) -> None:
        self.quiet = quiet
        self.verbose = verbose
        self._begin = time.perf_counter()
        self._progress: PlainProgress | None = None

    def say(self, text: str) -> None:
        """A line about what is going on."""
        if self.quiet:
            return
        if self._progress is not None:
            self._progress.line(text)
        else:
            print(text, file=sys.stderr)

    def detail(self, text: str) -> None:
        """A line for those who want to know more (-v)."""
        if self.verbose:
            self.say(text)

    def stage(self, text: str) -> None:
        """What begins now, while something works."""
        if self._progress is not None:
            self._progress.stage(text)

    def iteration(self, step: Iteration) -> None:
        """Progress of an adjustment."""
        if self._progress is not None:
            self._progress.iteration(step, self.verbose)

    @contextmanager
    def working(self) -> Iterator[None]:
        """While a long part of a command runs: its stages and iterations are shown."""
        import logging

        from splinebba_cli.commands.progress import StageListener, progress_for

        self._progress = progress_for(self.quiet)
        try:
            self._progress.start()
            with StageListener(self._progress, logging.DEBUG if self.verbose > 1 else logging.INFO):
                yield
        finally:
            self._progress.close()
            self._progress = None

    def finished(self, seconds: Mapping[str, float] | None = None) -> None:
        """How long it took, by parts where these are given, and how much memory (-v)."""
        if self.verbose:
            parts = [f"{name} {value:.2f} s" for name, value in (seconds or {}).items()]
            parts.append(f"in all {time.perf_counter() - self._begin:.2f} s")
            self.say(f"time: {', '.join(parts)}")
            self.say(f"memory: {_peak_memory()}")

    def warnings(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Warnings of a project."""
        if self.quiet:
            return
        console = self._progress.console() if self._progress is not None else rich_console(to_stdout=False)
        _print_each(diagnostics, console)


def _peak_memory() -> str:
    """The most memory that this process has held at a time."""
    try:
        import resource
    except ImportError:
        return "not known on this system"
    unit = 1 if sys.platform == "darwin" else 1024
    peak = unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return f"at most {peak / 2**20:.0f} MiB"


def print_diagnostics(diagnostics: Sequence[Diagnostic], *, to_stdout: bool) -> None:
    """Diagnostics with snippet and caret."""
    _print_each(diagnostics, rich_console(to_stdout=to_stdout))


def _print_each(diagnostics: Sequence[Diagnostic], console: RichConsole) -> None:
    from rich.text import Text

    from splinebba_cli.project.diagnostics import SEVERITY_STYLES, render_text

    for item in diagnostics:
        text = Text(render_text([item]))
        text.stylize(SEVERITY_STYLES[item.severity], 0, len(f"{item.severity}[{item.code}]"))
        for word, style in ((" | ", "blue"), ("= help:", "cyan")):
            text.highlight_words([word], style)
        console.print(text, soft_wrap=True)
        console.print()


def print_annotations(project: Path, problems: Sequence[Problem]) -> None:
    """Problems of a result as workflow commands of GitHub, on stdout."""
    from splinebba_cli.project.annotations import problem_diagnostics
    from splinebba_cli.project.diagnostics import render_github

    if problems:
        print(render_github(problem_diagnostics(project, problems)))


def print_error_annotations(project: Path, error: SplinebbaError) -> None:
    """An expected error as workflow commands of GitHub, on stdout."""
    from splinebba_cli.core.result import Problem
    from splinebba_cli.project.diagnostics import render_github

    if isinstance(error, ProjectError):
        print(render_github(error.diagnostics))
    elif isinstance(error, NotSolvableError) and error.problems:
        print_annotations(project, error.problems)
    else:
        print_annotations(project, [Problem(error.code, "error", error.message, "", error.help)])


def problem_text(problem: Problem) -> str:
    """A problem as lines of text."""
    lines = [f"{problem.severity}[{problem.code}]: {problem.message}"]
    if problem.subject and problem.subject not in problem.message:
        lines.append(f"  --> {problem.subject}")
    if problem.help:
        lines.append(f"  = help: {problem.help}")
    return "\n".join(lines)


def problem_data(problem: Problem) -> dict[str, Any]:
    """A problem as plain data: code, severity, message, subject, help."""
    return asdict(problem)


@contextmanager
def expected_errors(as_json: bool = False) -> Iterator[None]:
    """Print expected errors in the user's words and exit with their code."""
    try:
        yield
    except SplinebbaError as error:
        if as_json:
            print_problems(error)
        elif isinstance(error, ProjectError):
            print_diagnostics(error.diagnostics, to_stdout=False)
            count = sum(item.severity == "error" for item in error.diagnostics)
            print(
                f"{count} error{'s' if count != 1 else ''} in {error.subject}; nothing was written",
                file=sys.stderr,
            )
        else:
            print(error_text(error), file=sys.stderr)
        raise typer.Exit(error.exit_code) from None


def error_text(error: SplinebbaError) -> str:
    """An expected error as text; of an unsolvable network, the diagnosis."""
    if isinstance(error, NotSolvableError) and error.problems:
        return "\n\n".join(problem_text(problem) for problem in error.problems)
    help = f"\n  = help: {error.help}" if error.help else ""
    return f"error[{error.code}]: {error.message}{help}"


def error_data(error: SplinebbaError) -> list[dict[str, Any]]:
    """An expected error as plain data: a list of problems."""
    if isinstance(error, ProjectError):
        from splinebba_cli.project.diagnostics import as_json_data

        return as_json_data(error.diagnostics)
    if isinstance(error, NotSolvableError) and error.problems:
        return [problem_data(problem) for problem in error.problems]
    return [{"code": error.code, "severity": "error", "message": error.message, "help": error.help}]


def print_problems(error: SplinebbaError) -> None:
    """An expected error as JSON on stdout; once, whatever else goes wrong afterwards."""
    print_json({"problems": error_data(error)})


def report_interruption(error: InterruptedRunError, as_json: bool) -> int:
    """Say that the run was interrupted; give the exit code."""
    from splinebba_cli.interruption import interruption_text

    text = interruption_text(error)
    print(text, file=sys.stderr)
    if as_json:
        print_problems(SplinebbaError(error.code, text))
    return error.exit_code
