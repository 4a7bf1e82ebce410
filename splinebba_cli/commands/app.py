"""The program ``splinebba``: its commands, and what happens when something goes wrong."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import Any

import typer
from typer.core import TyperGroup

from splinebba_cli import __version__
from splinebba_cli.commands import (
    adjust,
    batch,
    chains,
    check,
    compare,
    explain,
    fit,
    init,
    match,
    report,
    schema,
    simulate,
)
from splinebba_cli.commands.lost_results import flush_results, is_lost, print_lost_results
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
        code: Any = ExitCode.DONE
        try:
            code = super().main(args, prog_name, complete_var, False, windows_expand_args, **extra)
            flush_results()
        except OSError as error:
            code = print_lost_results(error, code)
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
        try:
            context = super().make_context(info_name, args, *rest, **extra)
        except KeyboardInterrupt as error:
            raise _interrupted(error, as_json) from None
        except OSError as error:
            raise _lost(error) from None
        context.meta["splinebba.json"] = as_json
        return context

    def invoke(self, ctx: Any) -> Any:
        """Run the command; an unexpected error is logged to a file and ends with exit code 70."""
        as_json = bool(ctx.meta.get("splinebba.json"))
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise _interrupted(error, as_json) from None
        except Exception as error:
            if belongs_to_typer(error):
                raise
            if is_lost(error):
                raise _lost(error) from None
            from splinebba_cli.commands.bug_report import report_bug

            report_bug(error, as_json)
            raise typer.Exit(ExitCode.BUG) from None


def _interrupted(error: KeyboardInterrupt, as_json: bool) -> typer.Exit:
    """Say so; the exit that follows."""
    from splinebba_cli.commands.console import report_interruption

    return typer.Exit(report_interruption(interruption_of(error), as_json))


def _lost(error: Exception) -> Exception:
    """The exit where stdout does not take what is printed: typer would make it a result that is not accepted."""
    return typer.Exit(print_lost_results(error)) if is_lost(error) else error


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"splinebba {__version__}")
        raise typer.Exit


EXIT_CODES = (
    "Exit codes: 0 done and accepted; 1 adjusted, but not accepted; 2 invalid project or usage, or output that "
    "cannot be written; 3 not solvable; 70 an error of the program; 130 interrupted by Ctrl-C, 143 by SIGTERM."
)

app = typer.Typer(
    cls=GuardedGroup,
    name="splinebba",
    help="Bundle block adjustment with points and three-dimensional curves.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog=f"`splinebba COMMAND --help` has the options of a command, and examples.\n\n{EXIT_CODES}",
)


@app.callback()
def program(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version."
    ),
) -> None:
    """Bundle block adjustment with points and three-dimensional curves."""


def _add(name: str, command: Callable[..., None], summary: str, *examples: str) -> None:
    """A command with its line in the list of all, and the examples below its options."""
    lines = "".join(f"\n  splinebba {name} {example}" for example in examples)
    app.command(name, short_help=summary, epilog=f"\b\nExamples:{lines}\n\n{EXIT_CODES}")(command)


_add(
    "init", init.init, "Write a project to start from.",
    "first_block",
    "vase --template close-range",
    "roads --polyline roads.geojson",
)  # fmt: skip
_add(
    "check", check.check, "Validate a project and count, without adjusting it.",
    "project.yaml",
    "project.yaml --format github",
)  # fmt: skip
_add(
    "chains", chains.chains, "Make a table of chains from traced lines.",
    "traced/*.json -o chains.csv",
    "DSC_1.txt DSC_2.txt --columns x1,y1,x2,y2",
    "edges/*.geojson --y-up 0 --spacing 5 --min-points 20",
)  # fmt: skip
_add(
    "match", match.match, "Find the splines of unlabelled chains.",
    "project.yaml",
    "project.yaml --new-curves -o labelled -v",
)  # fmt: skip
_add(
    "adjust", adjust.adjust, "Adjust a project and write its results.",
    "project.yaml",
    "project.yaml -o results --outliers snooping -v",
    "project.yaml -q --format json > summary.json",
)  # fmt: skip
_add(
    "batch", batch.batch, "Adjust many projects side by side.",
    "blocks/*/project.yaml --jobs 4",
    "'blocks/**/project.yaml' --junit batch.xml --resume",
)  # fmt: skip
_add(
    "report", report.report, "Build the report of a result folder again.",
    "project.results",
    "project.results --format pdf -o report.pdf",
    "project.results --format markdown -o -",
)  # fmt: skip
_add(
    "simulate", simulate.simulate, "Simulate a project, a campaign, or precision.",
    "list",
    "six-image-mixed -o block --seed 3",
    "project.yaml --runs 500 --jobs 4",
    "project.yaml --predict",
)  # fmt: skip
_add(
    "fit", fit.fit, "Fit splines with few knots to digitised points.",
    "coast.geojson --threshold-m 0.2",
    "kerb.csv --role control --sigma 0.02 --figure kerb.svg",
)  # fmt: skip
_add(
    "compare", compare.compare, "Compare two results and the significance.",
    "first.results second.results",
    "first.results second.results --fail-on-difference -q",
)  # fmt: skip
_add(
    "schema", schema.schema, "Print the JSON Schema of a file.",
    "project > project.schema.json",
)  # fmt: skip
_add(
    "explain", explain.explain, "Say what an error code means.",
    "SBB301",
    "all",
)  # fmt: skip
