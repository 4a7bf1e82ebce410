"""The summary of a matching on the console: verdict, problems, key figures, images, splines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from splinebba_cli.report.blocks import Table
from splinebba_cli.report.console import STYLES, fact_grid, problem_lines, rich_table
from splinebba_cli.report.match_headline import match_facts, match_verdict
from splinebba_cli.report.match_sections import images_section, splines_section, unmatched_section
from splinebba_cli.report.result_data import ResultData

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType


class MatchSummary:
    """A rich renderable of the content of match.json."""

    def __init__(self, content: dict[str, Any]) -> None:
        self._content = content

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        """Blocks from top to bottom."""
        from rich.text import Text

        opinion = match_verdict(self._content)
        yield Text(opinion.headline, style=STYLES[opinion.tone])
        yield Text(opinion.detail)
        yield Text()
        yield from problem_lines(ResultData(self._content))
        yield fact_grid(match_facts(self._content))
        yield Text()
        for table in self._tables():
            yield from rich_table(table, options.max_width)

    def _tables(self) -> Iterator[Table]:
        """Why points have no spline; images and splines, the worst first, those of the project before new ones."""
        content = self._content
        sections = (unmatched_section(content), images_section(content), splines_section(content))
        orders = (
            None,
            [(False, image["share"] if image["share"] is not None else 2.0) for image in content["images"]],
            [(spline["new"], spline["points"]) for spline in content["splines"]],
        )
        for section, order in zip(sections, orders, strict=True):
            for block in section.blocks:
                if isinstance(block, Table):
                    yield block if order is None else _smallest_first(block, order)


def _smallest_first(table: Table, values: list[tuple[bool, float]]) -> Table:
    """The rows with the smallest values first."""
    order = sorted(range(len(table.rows)), key=lambda row: (values[row], row))
    return replace(
        table,
        rows=tuple(table.rows[row] for row in order),
        marked=frozenset(place for place, row in enumerate(order) if row in table.marked),
    )
