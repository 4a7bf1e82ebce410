"""Options of ``splinebba batch``: which projects, who adjusts them, who is told."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_LONGEST_S = 4_000_000.0  # clocks of some systems end after 49 days

TargetsArgument = Annotated[
    list[str],
    typer.Argument(
        metavar="TARGET",
        help="Project files, folders with a project.yaml, patterns such as 'blocks/**/project.yaml'.",
        show_default=False,
    ),
]
FolderOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="DIR",
        help="One folder for all results, with the folders of the projects inside. Default: beside each.",
    ),
]
JobsOption = Annotated[
    int | None,
    typer.Option(
        "--jobs", "-j", metavar="N", min=1, help="Worker processes. Default: one a core.", show_default=False
    ),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Scheduler of dask.distributed (tcp://host:8786) whose workers adjust.",
    ),
]
MatchOption = Annotated[
    bool,
    typer.Option(
        "--match",
        help="Match the chains of projects that have some first; their labelled projects are adjusted.",
    ),
]
TimeoutOption = Annotated[
    float | None,
    typer.Option(
        "--timeout", metavar="SECONDS", min=0.001, max=_LONGEST_S, help="Longest time for a project."
    ),
]
FailFastOption = Annotated[
    bool, typer.Option("--fail-fast", help="Stop at the first project that is not accepted.")
]
ResumeOption = Annotated[
    bool,
    typer.Option("--resume", help="Keep results of the same program, options and files; adjust the others."),
]
DryRunOption = Annotated[
    bool, typer.Option("--dry-run", help="List projects and result folders; adjust nothing.")
]
JunitOption = Annotated[
    Path | None,
    typer.Option(
        "--junit", metavar="FILE", help="JUnit XML to write: a suite a project, a case a criterion."
    ),
]
StepSummaryOption = Annotated[
    Path | None,
    typer.Option(
        "--step-summary",
        metavar="FILE",
        help="File to append a summary in Markdown to. Default: $GITHUB_STEP_SUMMARY where that is set.",
        show_default=False,
    ),
]
LogOption = Annotated[
    Path | None,
    typer.Option(
        "--log", metavar="FILE", help="Log to write: a line of JSON a project, as soon as it is finished."
    ),
]
