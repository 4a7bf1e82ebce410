"""The program ``splinebba``: its commands, and what happens when something goes wrong."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

import typer
from typer.core import TyperGroup

from splinebba_cli import __version__
from splinebba_cli.__main__ import main as main  # where console scripts of earlier installations look for it
from splinebba_cli.commands import adjust, check, compare, explain, fit, report, schema, simulate
from splinebba_cli.commands.usage_errors import belongs_to_typer, print_usage_error, wants_json
from splinebba_cli.errors import ExitCode
from splinebba_cli.interruption import interruption_of


class GuardedGroup(TyperGroup):
    """A group of commands that never shows a bare traceback, and that speaks JSON where JSON is wanted."""

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        windows_expand_args: bool = True,
        **extra: Any,
    ) -> Any:
        """Run a command line and exit with its code; usage errors are printed as all others are."""
        arguments = list(sys.argv[1:] if args is None else args)
        try:
            code = super().main(args, prog_name, complete_var, False, windows_expand_args, **extra)
        except Exception as error:
            if not standalone_mode or not belongs_to_typer(error):
                raise
            code = print_usage_error(error, as_json=wants_json(arguments))
        if not standalone_mode:
            return code
        sys.exit(code if isinstance(code, int) else ExitCode.DONE)

    def make_context(self, info_name: str | None, args: list[str], *rest: Any, **extra: Any) -> Any:
        """Remember what was asked for: an unexpected error is told as JSON, too."""
        as_json = wants_json(args)
        context = super().make_context(info_name, args, *rest, **extra)
        context.meta["splinebba.json"] = as_json
        return context

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an unexpected error is logged to a file and ends with exit code 70."""
        as_json = bool(ctx.meta.get("splinebba.json"))
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            _silence_stdout()
            raise typer.Exit(ExitCode.DONE) from None
        except KeyboardInterrupt as error:
            from splinebba_cli.commands.console import report_interruption

            raise typer.Exit(report_interruption(interruption_of(error), as_json)) from None
        except Exception as error:
            if belongs_to_typer(error):
                raise
            from splinebba_cli.commands.bug_report import report_bug

            report_bug(error, as_json)
            raise typer.Exit(ExitCode.BUG) from None


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
        "Exit codes: 0 done and accepted; 1 adjusted, but not accepted; 2 invalid project or usage, or output that "
        "cannot be written; 3 not solvable; 70 an error of the program; 130 and 143 interrupted."
    ),
)


@app.callback()
def program(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version."
    ),
) -> None:
    """Bundle block adjustment with points and three-dimensional curves."""


app.command("check")(check.check)
app.command("adjust")(adjust.adjust)
app.command("report")(report.report)
app.command("simulate")(simulate.simulate)
app.command("fit")(fit.fit)
app.command("compare")(compare.compare)
app.command("schema")(schema.schema)
app.command("explain")(explain.explain)
