"""The program ``splinebba``: its commands, and what happens when something goes wrong."""

from __future__ import annotations

import gc
import sys
from typing import Any

import typer
from typer.core import TyperGroup

from splinebba_cli import __version__
from splinebba_cli.commands import adjust, check, compare, explain, fit, init, report, schema, simulate
from splinebba_cli.errors import ExitCode

COLLECT_AFTER = 100_000  # new objects


class GuardedGroup(TyperGroup):
    """A group of commands that never shows a bare traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an unexpected error is logged to a file and ends with exit code 70."""
        from splinebba_cli.commands.console import report_bug

        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            _silence_stdout()
            raise typer.Exit(ExitCode.DONE) from None
        except RecursionError as error:
            report_bug(error)
            raise typer.Exit(ExitCode.BUG) from None
        except (RuntimeError, KeyboardInterrupt) as error:
            if _belongs_to_click(error):
                raise
            report_bug(error)
            raise typer.Exit(ExitCode.BUG) from None
        except Exception as error:
            if _belongs_to_click(error):
                raise
            report_bug(error)
            raise typer.Exit(ExitCode.BUG) from None


def _belongs_to_click(error: BaseException) -> bool:
    """Whether click itself handles it: usage errors, exits, aborts."""
    return isinstance(error, KeyboardInterrupt) or any(
        base.__module__.partition(".")[0] in ("click", "typer") for base in type(error).__mro__
    )


def _silence_stdout() -> None:
    """The reader has gone: let the interpreter's last flush go nowhere."""
    import os

    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"splinebba {__version__}")
        raise typer.Exit


app = typer.Typer(
    cls=GuardedGroup,
    name="splinebba",
    help="Bundle block adjustment with points and three-dimensional curves.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog=(
        "Exit codes: 0 done and accepted; 1 adjusted, but not accepted; 2 invalid project or usage; "
        "3 not solvable; 70 an error of the program."
    ),
)


@app.callback()
def program(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version."
    ),
) -> None:
    """Bundle block adjustment with points and three-dimensional curves."""


app.command("init")(init.init)
app.command("check")(check.check)
app.command("adjust")(adjust.adjust)
app.command("report")(report.report)
app.command("simulate")(simulate.simulate)
app.command("fit")(fit.fit)
app.command("compare")(compare.compare)
app.command("schema")(schema.schema)
app.command("explain")(explain.explain)


def main() -> None:
    """Entry point of the console script.

    The collector of cyclic garbage looks rarely: a run makes many objects that it keeps, and hardly any cycles.  At the
    end it does not look at all of them once more.
    """
    gc.set_threshold(COLLECT_AFTER, 20, 50)
    try:
        app(prog_name="splinebba")
    finally:
        gc.freeze()
