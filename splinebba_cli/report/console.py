"""The summary of an adjustment on the console: verdict, problems, key figures, orientations, splines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from splinebba_cli.output.result_json import result_to_dict
from splinebba_cli.project.diagnostics import SEVERITY_STYLES
from splinebba_cli.report.blocks import Column, Facts, ProblemList, Table, Tone, cell_text
from splinebba_cli.report.feature_sections import splines_table
from splinebba_cli.report.orientation_section import orientation_table
from splinebba_cli.report.result_data import ResultData
from splinebba_cli.report.sections import key_facts, problems_section, verdict

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType

    from splinebba_cli.core.result import AdjustmentResult

_ROWS = 12
_PROBLEMS = 12
STYLES: dict[Tone, str] = {
    "good": "bold green",
    "warning": "bold yellow",
    "bad": "bold red",
    "neutral": "bold",
}


def console_summary(result: AdjustmentResult) -> ConsoleSummary:
    """What the console says after an adjustment.

    Parameters
    ----------
    result : AdjustmentResult

    Returns
    -------
    ConsoleSummary
        Print it with ``rich.console.Console.print``; it leaves out columns where the console is narrow.
    """
    return ConsoleSummary(ResultData(result_to_dict(result)))


class ConsoleSummary:
    """A rich renderable of the compact summary.

    Parameters
    ----------
    data : ResultData
    """

    def __init__(self, data: ResultData) -> None:
        self._data = data

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Blocks from top to bottom."""
        from rich.text import Text

        opinion = verdict(self._data)
        yield Text(opinion.headline, style=STYLES[opinion.tone])
        yield Text(opinion.detail)
        yield Text()
        yield from problem_lines(self._data)
        yield fact_grid(key_facts(self._data))
        yield Text()
        if self._data["images"]:
            sigma = [max(image["sigma"][axis] or 0.0 for axis in "xyz") for image in self._data["images"]]
            yield from rich_table(worst_first(orientation_table(self._data), sigma), options.max_width)
        if self._data["splines"]:
            sigma = [spline["sigma_across"]["max"] or 0.0 for spline in self._data["splines"]]
            yield from rich_table(worst_first(splines_table(self._data), sigma), options.max_width)


def problem_lines(data: ResultData) -> Iterator[RenderableType]:
    """Problems, the worst first, with what would cure them; of many the first ones."""
    from rich.text import Text

    block = problems_section(data).blocks[0]
    items = block.items if isinstance(block, ProblemList) else ()
    for item in items[:_PROBLEMS]:
        text = Text.assemble(
            (f"{item.severity}[{item.code}]", SEVERITY_STYLES[item.severity]),
            f" {item.sentence}",
        )
        if item.help:
            text.append(f"\n    help: {item.help}", style="dim")
        yield text
    if len(items) > _PROBLEMS:
        yield Text(f"… and {len(items) - _PROBLEMS} more problems in the report", style="dim")
    if items:
        yield Text()


def fact_grid(facts: Facts) -> RenderableType:
    """Labelled values below each other."""
    from rich.table import Table as RichTable

    grid = RichTable.grid(padding=(0, 2))
    grid.add_column()
    grid.add_column(justify="right")
    grid.add_column(style="dim")
    for fact in facts.items:
        grid.add_row(_plain(fact.label), _plain(fact.value), _plain(fact.note))
    return grid


def _plain(text: str) -> RenderableType:
    """Text without rich markup: ids may hold square brackets."""
    from rich.text import Text

    return Text(text)


def worst_first(table: Table, sigma: Sequence[float]) -> Table:
    """A table of more rows than are shown begins with the largest σ."""
    if len(table.rows) <= _ROWS:
        return table
    order = sorted(range(len(table.rows)), key=lambda row: -sigma[row])
    return replace(
        table,
        caption=f"{table.caption}: the largest σ",
        rows=tuple(table.rows[row] for row in order),
        marked=frozenset(place for place, row in enumerate(order) if row in table.marked),
    )


def rich_table(table: Table, width: int) -> Iterator[RenderableType]:
    """A table of a report for the console: its first rows, and the columns that fit into `width`."""
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    shown = table.rows[:_ROWS]
    cells = [[cell_text(c, x) for c, x in zip(table.columns, row, strict=True)] for row in shown]
    kept = _columns_that_fit(table.columns, cells, width)
    shown_table = RichTable(
        title=table.caption, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False
    )
    for i in kept:
        column = table.columns[i]
        heading = Text("\n".join([column.title, f"[{column.unit}]"] if column.unit else [column.title]))
        shown_table.add_column(heading, justify="right" if column.numeric else "left", no_wrap=True)
    for number, row in enumerate(cells):
        shown_table.add_row(*(Text(row[i]) for i in kept), style="yellow" if number in table.marked else "")
    yield shown_table
    notes = []
    if len(table.rows) > _ROWS:
        notes.append(f"… and {len(table.rows) - _ROWS} more")
    if len(kept) < len(table.columns):
        notes.append(f"{len(table.columns) - len(kept)} columns left out to fit the width")
    if notes:
        yield Text("; ".join(notes) + f" ({table.source})" if table.source else "; ".join(notes), style="dim")
        yield Text()


def _columns_that_fit(columns: tuple[Column, ...], cells: list[list[str]], width: int) -> list[int]:
    """The columns from the left that fit into `width`, the gap of two included."""
    kept: list[int] = []
    used = 0
    for i, column in enumerate(columns):
        used += 3 + max([len(column.title), len(column.unit) + 2, *(len(row[i]) for row in cells)])
        if used > width and kept:
            break
        kept.append(i)
    return kept
