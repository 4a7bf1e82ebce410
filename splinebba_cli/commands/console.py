"""What goes to the terminal: results to stdout; log, progress and errors to stderr."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.errors import NotSolvableError, ProjectError, SplinebbaError

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console as RichConsole

    from splinebba_cli.core.result import Iteration, Problem
    from splinebba_cli.project.diagnostics import Diagnostic

_STYLES = {"error": "bold red", "warning": "bold yellow", "info": "bold cyan"}


class Log:
    """Messages and progress on stderr."""

    def __init__(self, quiet: bool = False, verbose: int = 0) -> None:
        self.quiet = quiet
        self.verbose = verbose

    def say(self, text: str) -> None:
        """A line about what is going on."""
        if not self.quiet:
            print(text, file=sys.stderr)

    def detail(self, text: str) -> None:
        """A line for those who want to know more (-v)."""
        if self.verbose and not self.quiet:
            print(text, file=sys.stderr)

    def iteration(self, step: Iteration) -> None:
        """Progress of an adjustment: one line an iteration."""
        moved = f"   step {step.step:9.3g} σ" if math.isfinite(step.step) else ""
        self.say(f"{step.stage:>8} {step.number:3d}   vᵀPv {step.cost:14.6g}{moved}")

    def warnings(self, diagnostics: Sequence[Diagnostic]) -> None:
        """Warnings of a project."""
        if not self.quiet:
            print_diagnostics(diagnostics, to_stdout=False)


def rich_console(*, to_stdout: bool = True) -> RichConsole:
    """A console of rich; it honours NO_COLOR and writes plain text where there is no terminal."""
    from rich.console import Console as RichConsole

    stream = sys.stdout if to_stdout else sys.stderr
    width = None if stream.isatty() else 120
    return RichConsole(file=stream, width=width, highlight=False, soft_wrap=False, emoji=False)


def print_diagnostics(diagnostics: Sequence[Diagnostic], *, to_stdout: bool) -> None:
    """Diagnostics with snippet and caret."""
    from rich.text import Text

    from splinebba_cli.project.diagnostics import render_text

    console = rich_console(to_stdout=to_stdout)
    for item in diagnostics:
        text = Text(render_text([item]))
        text.stylize(_STYLES[item.severity], 0, len(f"{item.severity}[{item.code}]"))
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


def print_json(data: Any) -> None:
    """JSON on stdout."""
    print(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


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
            print_json({"problems": error_data(error)})
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


def report_bug(error: BaseException) -> None:
    """Log the traceback of an unexpected error to a file and say where it is."""
    import tempfile
    import traceback

    from splinebba_cli import __version__

    text = "".join(traceback.format_exception(error))
    print(
        f"error[SBB970]: unexpected error inside the program: {type(error).__name__}: {error}",
        file=sys.stderr,
    )
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="splinebba-error-", suffix=".log", delete=False, encoding="utf-8"
        ) as log:
            log.write(f"splinebba {__version__}, Python {sys.version}\n{' '.join(sys.argv)}\n\n{text}")
    except OSError:
        print(
            "  the traceback could not be written to a file; run again with -X dev to see it", file=sys.stderr
        )
        return
    print(f"  the details are in {log.name}", file=sys.stderr)
    print("  = help: this is a bug; please report it with that file", file=sys.stderr)
