"""Errors of the command line, told as all other errors are: code, what is wrong, what cures it; as text or JSON."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from splinebba_cli.errors import ExitCode

_CODE = "SBB900"


def belongs_to_typer(error: BaseException) -> bool:
    """Whether typer raised it: usage errors, exits, aborts."""
    return any(base.__module__.partition(".")[0] in ("click", "typer") for base in type(error).__mro__)


def wants_json(arguments: Sequence[str]) -> bool:
    """Whether a command line asks for JSON, even one that is wrong elsewhere."""
    return "--format=json" in arguments or ("--format", "json") in pairwise(arguments)


def print_usage_error(error: Any, *, as_json: bool) -> int:
    """Print an error of typer and give the exit code; without any command: the help."""
    if type(error).__name__ == "NoArgsIsHelpError":
        print(error.format_message(), file=sys.stderr)
    elif not hasattr(error, "format_message"):  # Abort
        print("aborted", file=sys.stderr)
    else:
        from splinebba_cli.commands.console import error_text, print_problems
        from splinebba_cli.errors import UsageError

        told = UsageError(_CODE, _message(error), _help(error))
        if as_json:
            print_problems(told)
        else:
            print(error_text(told), file=sys.stderr)
    return ExitCode.INVALID


def _message(error: Any) -> str:
    """What is wrong, as typer says it, but as a part of a line of ours."""
    possible = getattr(error, "possibilities", None)
    text = error.message if possible else error.format_message()
    text = str(text).replace("Value error, ", "").partition(" Did you mean ")[0].strip().rstrip(".")
    return text[:1].lower() + text[1:]


def _help(error: Any) -> str:
    """The likely word where one was mistyped, and where all words stand."""
    context = getattr(error, "ctx", None)
    where = f"`{context.command_path} --help` lists what there is" if context is not None else ""
    similar = [f"`{name}`" for name in getattr(error, "possibilities", None) or ()]
    if not similar:
        similar = str(error.message).partition(" Did you mean ")[2].rstrip("?").replace("'", "`").split(", ")
        similar = [name for name in similar if name]
    meant = f"did you mean {' or '.join(similar)}?" if similar else ""
    return " ".join(part for part in (meant, where) if part)
