"""Problems of a result as diagnostics of the project file: where a criterion or a feature stands in it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from splinebba_cli.core.result import Problem
from splinebba_cli.project.diagnostics import Collector, Diagnostic, Place
from splinebba_cli.project.yaml_source import YamlSource, read_yaml

_ACCEPTANCE = "acceptance."


def problem_diagnostics(path: Path, problems: Iterable[Problem]) -> tuple[Diagnostic, ...]:
    """Diagnostics for every problem; those of acceptance criteria point at their line."""
    source = read_yaml(path, Collector())
    return tuple(_one(path, source, problem) for problem in problems)


def _one(path: Path, source: YamlSource | None, problem: Problem) -> Diagnostic:
    place = Place(str(path))
    if source is not None and problem.subject.startswith(_ACCEPTANCE):
        place = source.place(("acceptance", problem.subject.removeprefix(_ACCEPTANCE)), key=True)
    named = not problem.subject or problem.subject in problem.message or place.line is not None
    message = problem.message if named else f"{problem.subject}: {problem.message}"
    return Diagnostic(
        problem.code, problem.severity, message, problem.help,
        place.file, place.line, place.column, place.length, place.snippet,
    )  # fmt: skip
