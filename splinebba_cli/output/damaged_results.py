"""A result folder that is not as it was written: its files cut, edited or mixed up."""

from __future__ import annotations

import csv
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

from splinebba_cli.errors import OutputError
from splinebba_cli.project.plain_text import brief, shown_lines

_DAMAGE = (
    ArithmeticError,
    AttributeError,
    BadZipFile,
    EOFError,
    LookupError,
    NotImplementedError,
    OSError,
    RecursionError,
    TypeError,
    ValueError,
    csv.Error,
    zlib.error,
)
#: What a text of result.json may hold that acts on a terminal: as it is, or as an escape.
_ACTING = re.compile(r"[\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]|\\[ubf]")


@contextmanager
def complete_results(folder: Path) -> Iterator[None]:
    """What goes wrong while stored results are read and used is damage of the folder.

    Raises
    ------
    OutputError
        SBB602, with what was not as expected.
    """
    try:
        yield
    except _DAMAGE as error:
        what = brief(f"{type(error).__name__}: {error}", 200)
        help = "adjust its project again; if that gives the same, please report it"
        raise OutputError("SBB602", f"`{folder}` is damaged or not complete: {what}", help) from error


def without_acting_characters(content: Any, text: str) -> Any:
    """Content of a JSON text, its strings as they may go to a terminal."""
    return _shown(content) if _ACTING.search(text) else content


def _shown(value: Any) -> Any:
    if isinstance(value, str):
        return shown_lines(value)
    if isinstance(value, dict):
        return {shown_lines(key): _shown(item) for key, item in value.items()}
    return [_shown(item) for item in value] if isinstance(value, list) else value


def no_constant(name: str) -> Any:
    """JSON has no NaN and no infinities; ValueError for them."""
    raise ValueError(f"{name} is no JSON number")
