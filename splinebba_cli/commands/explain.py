"""``splinebba explain``: what an error code means."""

from __future__ import annotations

from typing import Annotated

import typer

from splinebba_cli.commands.console import expected_errors
from splinebba_cli.errors import ERROR_CODES, UsageError


def explain(
    code: Annotated[
        str, typer.Argument(metavar="CODE", help="Code such as SBB301; `all` lists them.")
    ] = "all",
) -> None:
    """Say what an error code means."""
    with expected_errors():
        if code == "all":
            print("\n".join(f"{key}  {title}" for key, title in ERROR_CODES.items()))
        elif code.upper() in ERROR_CODES:
            print(f"{code.upper()}: {ERROR_CODES[code.upper()]}")
        else:
            raise UsageError("SBB900", f"no error code `{code}`", "`splinebba explain all` lists the codes")
