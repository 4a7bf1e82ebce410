"""Options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class OutputFormat(StrEnum):
    """How results are printed."""

    text = "text"
    json = "json"


class CheckFormat(StrEnum):
    """How findings are printed."""

    text = "text"
    json = "json"
    github = "github"


class DispersionChoice(StrEnum):
    """How much of the dispersion matrix is kept."""

    full = "full"
    blocks = "blocks"
    none = "none"


class TableChoice(StrEnum):
    """Format of the result tables."""

    csv = "csv"
    parquet = "parquet"


class OutlierChoice(StrEnum):
    """What is done with gross errors."""

    none = "none"
    snooping = "snooping"
    huber = "huber"
    cauchy = "cauchy"
    tukey = "tukey"
    danish = "danish"


class ReportChoice(StrEnum):
    """Format of a report; json: what was written is told as JSON."""

    html = "html"
    text = "text"
    markdown = "markdown"
    json = "json"
    pdf = "pdf"


class SchemaChoice(StrEnum):
    """Which schema."""

    project = "project"
    result = "result"
    campaign = "campaign"
    match = "match"


ProjectArgument = Annotated[
    Path,
    typer.Argument(
        metavar="PROJECT", help="Project file, or a folder with a project.yaml.", show_default=False
    ),
]
CheckFormatOption = Annotated[
    CheckFormat,
    typer.Option("--format", help="How results are printed; github: annotations of a workflow."),
]
DispersionOption = Annotated[
    DispersionChoice, typer.Option("--dispersion", help="How much of the dispersion matrices is kept.")
]
TablesOption = Annotated[TableChoice, typer.Option("--tables", help="Format of the result tables.")]
OutliersOption = Annotated[
    OutlierChoice | None,
    typer.Option("--outliers", help="What is done with gross errors; default: as the project says."),
]
HtmlOption = Annotated[bool, typer.Option("--html/--no-html", help="Whether report.html is written.")]
FormatOption = Annotated[OutputFormat, typer.Option("--format", help="How results are printed.")]


def _not_both(context: typer.Context, value: int) -> int:
    """Refuse -q and -v together: nobody wants less and more."""
    if value and any(context.params.get(name) for name in ("quiet", "verbose")):
        raise typer.BadParameter("--quiet and --verbose contradict each other", ctx=context)
    return value


QuietOption = Annotated[
    bool,
    typer.Option(
        "--quiet", "-q", callback=_not_both, help="Only results and errors: no progress, no warnings."
    ),
]
VerboseOption = Annotated[
    int,
    typer.Option(
        "--verbose",
        "-v",
        count=True,
        callback=_not_both,
        show_default=False,
        help="Times, sizes and memory on stderr; -vv: ordering and damping as well.",
    ),
]
