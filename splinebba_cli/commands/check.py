"""``splinebba check``: validate a project, count, and look at the rank; no solution."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.commands.console import (
    Log,
    error_data,
    expected_errors,
    print_annotations,
    print_diagnostics,
    print_error_annotations,
    print_json,
    problem_data,
    problem_text,
    rich_console,
)
from splinebba_cli.commands.options import (
    CheckFormat,
    CheckFormatOption,
    ProjectArgument,
    QuietOption,
    VerboseOption,
)
from splinebba_cli.errors import ExitCode, NotSolvableError, ProjectError

if TYPE_CHECKING:
    from splinebba_cli.core.budget import Budget
    from splinebba_cli.project.loading import LoadedProject


def check(
    project: ProjectArgument,
    format: CheckFormatOption = CheckFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Validate a project: errors, counts, redundancy budget and rank. Computes no solution."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is CheckFormat.json), _findings_as_results(format):
        from splinebba_cli.core.budget import budget
        from splinebba_cli.project.loading import load_project

        with log.working():
            loaded = load_project(project)
            with _told_with(loaded, format, quiet):
                found = budget(loaded.network)
        log.detail(f"size: {found.equations} equations, {found.unknowns} unknowns")
        log.finished()
        if format is CheckFormat.json:
            print_json(check_data(loaded, found))
        else:
            _print_findings(() if quiet else loaded.diagnostics, format)
            _print_budget(loaded, found, format)
    if any(problem.severity == "error" for problem in found.problems):
        raise typer.Exit(ExitCode.NOT_SOLVABLE)


@contextmanager
def _findings_as_results(format: CheckFormat) -> Iterator[None]:
    """What is wrong with a project is the result of `check`: it goes to stdout."""
    try:
        yield
    except ProjectError as error:
        if format is CheckFormat.json:
            raise
        _print_findings(error.diagnostics, format)
        count = sum(item.severity == "error" for item in error.diagnostics)
        if format is CheckFormat.text:
            print(f"{count} error{'s' if count != 1 else ''}")
        raise typer.Exit(ExitCode.INVALID) from None


@contextmanager
def _told_with(loaded: LoadedProject, format: CheckFormat, quiet: bool) -> Iterator[None]:
    """A project without a budget: its warnings are told before the error, they often name the cause."""
    from splinebba_cli.project.diagnostics import as_json_data

    try:
        yield
    except NotSolvableError as error:
        if format is CheckFormat.json:
            print_json({"problems": [*as_json_data(loaded.diagnostics), *error_data(error)]})
            raise typer.Exit(error.exit_code) from None
        _print_findings(() if quiet else loaded.diagnostics, format)
        if format is CheckFormat.github:
            print_error_annotations(loaded.path, error)
        raise


def counts(loaded: LoadedProject) -> dict[str, int]:
    """How many of everything there are."""
    network = loaded.network
    return {
        "cameras": len(network.cameras),
        "images": len(network.images.ids),
        "splines": len(network.curves),
        "points": len(network.points.ids),
        "spline_observations": len(network.curve_observations),
        "point_observations": len(network.point_observations),
        "arc_lengths": len(network.arc_lengths),
        "tangents": len(network.tangents),
    }


def check_data(loaded: LoadedProject, found: Budget) -> dict[str, Any]:
    """What ``check --format json`` prints."""
    from splinebba_cli.project.diagnostics import as_json_data

    return {
        "project": loaded.name,
        "counts": counts(loaded),
        "budget": {
            key: getattr(found, key) for key in ("equations", "unknowns", "rank", "nullity", "redundancy")
        },
        "features": [asdict(feature) for feature in found.features],
        "images": [asdict(image) for image in found.images],
        "problems": [*as_json_data(loaded.diagnostics), *map(problem_data, found.problems)],
    }


def _print_findings(diagnostics: Any, format: CheckFormat) -> None:
    if format is CheckFormat.github:
        from splinebba_cli.project.diagnostics import render_github

        if diagnostics:
            print(render_github(diagnostics))
    else:
        print_diagnostics(diagnostics, to_stdout=True)


def _print_budget(loaded: LoadedProject, found: Budget, format: CheckFormat) -> None:
    if format is CheckFormat.github:
        print_annotations(loaded.path, found.problems)
        return
    from splinebba_cli.report.budget_tables import BudgetTables

    console = rich_console()
    for problem in found.problems:
        console.print(problem_text(problem) + "\n", markup=False, soft_wrap=True)
    number = counts(loaded)
    console.print(loaded.name, style="bold", markup=False)
    measured = (
        f"  {number['images']} images, {number['splines']} splines with {number['spline_observations']} "
        f"measured points, {number['points']} points with {number['point_observations']} measured points"
    )
    budget = (
        f"  {found.equations} equations, {found.unknowns} unknowns, rank {found.rank}, "
        f"nullity {found.nullity}, redundancy {found.redundancy} (before gauge and datum conditions)"
    )
    linked = _counted_linked(number)
    console.print(f"{measured}{linked}\n{budget}\n", markup=False, soft_wrap=True)
    console.print(BudgetTables(found))


def _counted_linked(number: dict[str, int]) -> str:
    """Arc lengths and tangents, if there are any."""
    names = (("arc_lengths", "arc lengths"), ("tangents", "tangents"))
    return "".join(f", {number[key]} {name}" for key, name in names if number[key])
