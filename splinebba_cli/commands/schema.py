"""``splinebba schema``: the JSON Schema of a file."""

from __future__ import annotations

from typing import Annotated

import typer

from splinebba_cli.commands.options import FormatOption, OutputFormat, SchemaChoice


def schema(
    which: Annotated[
        SchemaChoice,
        typer.Argument(metavar="WHICH", help="Of which file: project, result, campaign or match."),
    ] = SchemaChoice.project,
    format: FormatOption = OutputFormat.text,
) -> None:
    """Print the JSON Schema of the project file, or of result.json, campaign.json or match.json."""
    from splinebba_cli.project.json_schema import schema_text

    print(schema_text(which.value), end="")
