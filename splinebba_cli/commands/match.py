"""``splinebba match``: the splines to which unlabelled chains belong."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

from splinebba_cli.commands import match_options as option
from splinebba_cli.commands.console import Log, expected_errors, print_json, rich_console
from splinebba_cli.commands.options import (
    FormatOption,
    OutputFormat,
    ProjectArgument,
    QuietOption,
    VerboseOption,
)
from splinebba_cli.errors import ExitCode

if TYPE_CHECKING:
    from splinebba_cli.jobs.match_job import MatchOutcome


def match(
    project: ProjectArgument,
    output: option.FolderOption = None,
    new_curves: option.NewCurvesOption = None,
    alpha: option.AlphaOption = None,
    rounds: option.RoundsOption = None,
    seed: option.SeedOption = None,
    html: option.HtmlOption = True,
    format: FormatOption = OutputFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Find the splines to which unlabelled image points and chains belong; write a project with labels."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is OutputFormat.json):
        from splinebba_cli.jobs.match_job import MatchOptions, run_match

        options = MatchOptions(output, new_curves, alpha, rounds, seed, html)
        with log.working():
            done = run_match(project, options, warned=log.warnings, iterated=log.iteration)
        log.finished(done.seconds)
        if format is OutputFormat.json:
            print_json(match_summary_data(done))
        else:
            _print_summary(done)
    if not done.accepted:
        raise typer.Exit(ExitCode.NOT_ACCEPTED)


def _print_summary(done: MatchOutcome) -> None:
    from splinebba_cli.project.matched import MATCHED_FILE
    from splinebba_cli.report.match_summary import MatchSummary

    console = rich_console()
    console.print(MatchSummary(done.content))
    console.print(f"Results: {done.directory}", markup=False, soft_wrap=True)
    line = f"Next: splinebba adjust {done.directory / MATCHED_FILE}"
    console.print(line, style="dim", markup=False, soft_wrap=True)


def match_summary_data(done: MatchOutcome) -> dict[str, Any]:
    """What ``match --format json`` prints: the head of match.json and all that was found."""
    from splinebba_cli.project.diagnostics import as_json_data
    from splinebba_cli.project.matched import MATCHED_FILE

    content = done.content
    return {
        "results": str(done.directory),
        "project": str(done.directory / MATCHED_FILE),
        "accepted": done.accepted,
        **{key: content[key] for key in ("counts", "reasons", "acceptance")},
        "problems": [*as_json_data(done.loaded.diagnostics), *content["problems"]],
    }
