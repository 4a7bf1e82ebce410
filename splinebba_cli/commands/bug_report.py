"""An unexpected error: what was wrong goes to a file, and the user is told where that is."""

from __future__ import annotations

import sys


def report_bug(error: BaseException, as_json: bool = False) -> None:
    """Log the traceback of an unexpected error to a file and say where it is.

    With ``python -X dev`` the traceback is shown as well.
    """
    from splinebba_cli.commands.console import error_text, print_problems
    from splinebba_cli.errors import SplinebbaError

    place = _logged(error)
    help = "this is a bug; please report it"
    help += (
        f" with the file {place}"
        if place
        else "; run again with `python -X dev -m splinebba_cli` to see more"
    )
    told = SplinebbaError(
        "SBB970", f"unexpected error inside the program: {type(error).__name__}: {error}", help
    )
    if sys.flags.dev_mode:
        import traceback

        traceback.print_exception(error)
    if as_json:
        print_problems(told)
    print(error_text(told), file=sys.stderr)
    if place:
        print(f"  the details are in {place}", file=sys.stderr)


def _logged(error: BaseException) -> str:
    """Name of the file with the traceback; empty where none can be written."""
    import tempfile
    import traceback

    from splinebba_cli import __version__

    text = "".join(traceback.format_exception(error))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="splinebba-error-", suffix=".log", delete=False, encoding="utf-8", errors="replace"
        ) as log:
            log.write(f"splinebba {__version__}, Python {sys.version}\n{' '.join(sys.argv)}\n\n{text}")
    except OSError:
        return ""
    return log.name
