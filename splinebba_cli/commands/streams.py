"""The two streams of a command: results on stdout, everything else on stderr; their colours and their width.

Colours (https://no-color.org): none where ``NO_COLOR`` is set and not empty; else where ``FORCE_COLOR`` is set and
neither empty nor 0; else on a terminal that is not ``TERM=dumb``.  Without colours no control character is written.
Width: on a terminal ``COLUMNS``, else its own; elsewhere always 120, so that logs and files do not depend on who wrote
them (``COLUMNS`` is inherited from shells and test runners).
"""

from __future__ import annotations

import json
import os
import sys
from typing import TYPE_CHECKING, Any, TextIO

if TYPE_CHECKING:
    from rich.console import Console as RichConsole

_WIDTH = 120  # where there is no terminal
_USUAL_WIDTH = 80  # of a terminal that does not tell its own
_LEAST_WIDTH = 30


def prepare_streams() -> None:
    """Make sure that no character of a result and no name of a file can make printing fail."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed by the caller
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="surrogateescape" if _is_unicode(stream) else "replace")


def rich_console(*, to_stdout: bool = True) -> RichConsole:
    """A console of rich for results or for messages."""
    from rich.console import Console as RichConsole

    stream = sys.stdout if to_stdout else sys.stderr
    coloured = has_colours(stream)
    return RichConsole(
        file=stream,
        width=width_of(stream),
        force_terminal=coloured,
        color_system=("auto" if is_terminal(stream) else "standard") if coloured else None,
        legacy_windows=False,
        highlight=False,
        soft_wrap=False,
        emoji=False,
    )


def live_console() -> RichConsole:
    """A console of rich on stderr for a line that changes; only where :func:`is_terminal` says so."""
    from rich.console import Console as RichConsole

    return RichConsole(
        file=sys.stderr,
        width=width_of(sys.stderr),
        force_terminal=True,
        color_system="auto" if has_colours(sys.stderr) else None,
        highlight=False,
        emoji=False,
    )


def has_colours(stream: TextIO) -> bool:
    """Whether control characters for colours may be written."""
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR", "0") not in ("", "0"):
        return True
    return is_terminal(stream)


def is_terminal(stream: TextIO) -> bool:
    """Whether a line on the stream can be written over."""
    return stream.isatty() and os.environ.get("TERM", "") not in ("dumb", "unknown")


def width_of(stream: TextIO) -> int:
    """Columns that a line may take."""
    if not stream.isatty():
        return _WIDTH
    asked = os.environ.get("COLUMNS", "")
    if asked.isdigit() and int(asked) > 0:
        return max(_LEAST_WIDTH, int(asked))
    try:
        found = os.get_terminal_size(stream.fileno()).columns
    except (OSError, ValueError):
        found = 0
    return max(_LEAST_WIDTH, found or _USUAL_WIDTH)


def print_json(data: Any) -> None:
    """JSON on stdout; characters that the stream has not are escaped."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except UnicodeEncodeError:
        text = json.dumps(data, indent=2, allow_nan=False)
    print(text)


def _is_unicode(stream: TextIO) -> bool:
    return (stream.encoding or "").lower().replace("-", "").startswith("utf")
