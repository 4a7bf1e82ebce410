"""``splinebba explain``: what an error code means."""

from __future__ import annotations

from typing import Annotated

import typer

from splinebba_cli.commands.console import expected_errors, print_json
from splinebba_cli.commands.options import FormatOption, OutputFormat
from splinebba_cli.errors import ERROR_CODES, UsageError


def explain(
    code: Annotated[
        str, typer.Argument(metavar="CODE", help="Code such as SBB301; `all` lists them.")
    ] = "all",
    format: FormatOption = OutputFormat.text,
) -> None:
    """Say what an error code means."""
    with expected_errors(as_json=format is OutputFormat.json):
        if code != "all" and code.upper() not in ERROR_CODES:
            raise UsageError("SBB900", f"no error code `{code}`", "`splinebba explain all` lists the codes")
        chosen = ERROR_CODES if code == "all" else {code.upper(): ERROR_CODES[code.upper()]}
        if format is OutputFormat.json:
            print_json({"codes": [{"code": key, "title": title} for key, title in chosen.items()]})
        elif code == "all":
            print("\n".join(f"{key}  {title}" for key, title in chosen.items()))
        else:
            print(f"{code.upper()}: {chosen[code.upper()]}")
