"""A batch on the console: what is wrong with which projects, then a table of all, the worst first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from splinebba_cli.batch.outcome import Outcome, Verdict, counted, worst_first
from splinebba_cli.project.diagnostics import SEVERITY_STYLES, Diagnostic

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

STYLES = {Verdict.accepted: "green", Verdict.not_run: "dim", Verdict.not_accepted: "yellow"}
BAD = "red"
_PROBLEMS = 3  # of a project
_WIDE = 10_000  # columns of a console on which everything fits


class BatchSummary:
    """A rich renderable.

    Parameters
    ----------
    outcomes : sequence of Outcome
    all_problems : bool
        Whether all problems of all projects are spelt out; else the first errors of those that are not accepted.
    """

    def __init__(self, outcomes: Sequence[Outcome], *, all_problems: bool = False) -> None:
        self._outcomes = worst_first(outcomes)
        self._all_problems = all_problems

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Problems, table, count."""
        from rich.text import Text

        for outcome in self._outcomes:
            yield from self._problems(outcome)
        yield from _table_that_fits(self._outcomes, console, options)
        yield Text(counted(self._outcomes), style="bold")

    def _problems(self, outcome: Outcome) -> Iterator[RenderableType]:
        from rich.text import Text

        if self._all_problems:
            shown = list(outcome.problems)
        elif outcome.verdict is Verdict.accepted:
            shown = []
        else:
            shown = [problem for problem in outcome.problems if problem.severity == "error"]
        if not shown:
            return
        yield Text(f"{outcome.project}: {outcome.verdict.value}", style=f"bold {_style(outcome)}")
        most = len(shown) if self._all_problems else _PROBLEMS
        for problem in shown[:most]:
            yield _problem(problem, outcome)
        if len(shown) > most:
            yield Text(f"  … and {len(shown) - most} more (-v shows all)", style="dim")
        if self._all_problems and outcome.details:
            yield Text(outcome.details, style="dim")
        yield Text()


def _problem(problem: Diagnostic, outcome: Outcome) -> RenderableType:
    from rich.text import Text

    text = Text.assemble(
        (f"  {problem.severity}[{problem.code}]", SEVERITY_STYLES[problem.severity]), f" {problem.message}"
    )
    if problem.position not in ("", outcome.project):
        text.append(f"\n    --> {problem.position}")
    if problem.help:
        text.append(f"\n    help: {problem.help}", style="dim")
    return text


def _table_that_fits(
    outcomes: Sequence[Outcome], console: Console, options: ConsoleOptions
) -> Iterator[RenderableType]:
    """Where the console is too narrow for all columns, the result folders are left out."""
    from rich.measure import Measurement
    from rich.text import Text

    whole = _table(outcomes, with_results=True)
    if Measurement.get(console, options.update_width(_WIDE), whole).maximum <= options.max_width:
        yield whole
        return
    yield _table(outcomes, with_results=False)
    yield Text("result folders left out to fit the width (--dry-run lists them)", style="dim")


def _table(outcomes: Sequence[Outcome], *, with_results: bool) -> RenderableType:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("Project", overflow="fold")
    table.add_column("Verdict", no_wrap=True)
    for heading in ("σ̂₀", "Redundancy", "Errors", "Warnings", "Infos", "Time [s]"):
        table.add_column(heading, justify="right", no_wrap=True)
    if with_results:
        table.add_column("Results", no_wrap=True)
    for outcome in outcomes:
        cells = [Text(outcome.project), Text(outcome.verdict.value, _style(outcome))]
        cells += map(Text, _figures(outcome))
        table.add_row(*cells, *([Text(outcome.results)] if with_results else []))
    return table


def _figures(outcome: Outcome) -> Iterator[str]:
    sigma0, redundancy = (outcome.statistics.get(key) for key in ("sigma0", "redundancy"))
    yield "" if sigma0 is None else f"{sigma0:.4f}"
    yield "" if redundancy is None else str(redundancy)
    yield from (str(outcome.count(severity) or "") for severity in ("error", "warning", "info"))
    yield "up to date" if outcome.up_to_date else f"{outcome.seconds:.1f}" if outcome.seconds else ""


def _style(outcome: Outcome) -> str:
    return STYLES.get(outcome.verdict, BAD)
