"""Results that find no way out: the reader of a pipe has gone, or the file that stdout goes to has no room."""

from __future__ import annotations

import os
import sys
from typing import TypeGuard

from splinebba_cli.errors import ExitCode
from splinebba_cli.write_errors import cannot_write, is_full


def is_lost(error: BaseException) -> TypeGuard[OSError]:
    """Whether stdout does not take what is printed."""
    return isinstance(error, BrokenPipeError) or (isinstance(error, OSError) and is_full(error))


def flush_results() -> None:
    """Let what was printed go out as long as somebody listens to errors."""
    sys.stdout.flush()


def print_lost_results(error: OSError, code: int | None = ExitCode.DONE) -> int:
    """Say so where it is an error, and give the exit code; a reader that has gone knows enough.

    Parameters
    ----------
    error : OSError
    code : int, optional
        Exit code of the command, as far as that is known.
    """
    _silence_stdout()
    if isinstance(error, BrokenPipeError):
        return code or ExitCode.DONE
    if not is_lost(error):
        raise error
    from splinebba_cli.commands.console import error_text

    print(error_text(cannot_write("what is printed", error)), file=sys.stderr)
    return ExitCode.INVALID


def _silence_stdout() -> None:
    """Let the interpreter's last flush go nowhere."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):  # stdout is no file
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
