"""``splinebba compare``: two results side by side, and whether they differ."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from splinebba_cli.commands.console import Log, expected_errors, print_json, rich_console
from splinebba_cli.commands.options import FormatOption, OutputFormat, QuietOption, VerboseOption
from splinebba_cli.errors import ExitCode, UsageError

if TYPE_CHECKING:
    from splinebba_cli.output.comparison_relation import RelationName


class RelationChoice(StrEnum):
    """How the adjustments are related."""

    auto = "auto"
    independent = "independent"
    nested = "nested"
    same_data = "same-data"
    overlapping = "overlapping"


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="Result folder of `adjust`.", show_default=False)],
    b: Annotated[Path, typer.Argument(metavar="B", help="Another one.", show_default=False)],
    relation: Annotated[
        RelationChoice,
        typer.Option(
            "--relation",
            help="independent: other measurements; nested: one has a part of the observations of the other; "
            "same-data: another model; overlapping: some in common. auto: by hashes and measurements.",
        ),
    ] = RelationChoice.auto,
    alpha: Annotated[
        float,
        typer.Option(
            "--alpha", metavar="SHARE", help="Significance of each kind of test, over all of its subjects."
        ),
    ] = 0.05,
    fail_on_difference: Annotated[
        bool, typer.Option("--fail-on-difference", help="Exit code 1 where anything differs significantly.")
    ] = False,
    format: FormatOption = OutputFormat.text,
    quiet: QuietOption = False,
    verbose: VerboseOption = 0,
) -> None:
    """Compare two results: statistics, tests of variances and models, differences with their significance."""
    log = Log(quiet, verbose)
    with expected_errors(as_json=format is OutputFormat.json):
        from splinebba_cli.output.comparison import compare as compare_results
        from splinebba_cli.output.comparison_json import comparison_to_dict

        if not 0.0 < alpha < 1.0:
            raise UsageError("SBB900", f"--alpha is a probability between 0 and 1, not {alpha:g}")
        wanted = None if relation is RelationChoice.auto else cast("RelationName", relation.value)
        with log.working():
            found = compare_results(a, b, relation=wanted, alpha=alpha)
            data = comparison_to_dict(found)
        log.finished()
        if format is OutputFormat.json:
            print_json(data)
        else:
            from splinebba_cli.report.comparison_tables import ComparisonText

            rich_console().print(ComparisonText(data))
    if fail_on_difference and found.significant:
        raise typer.Exit(ExitCode.NOT_ACCEPTED)
