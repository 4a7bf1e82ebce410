"""report.md: the report in GitHub-flavoured Markdown, short enough for a pull request or an issue."""

from __future__ import annotations

from collections.abc import Iterable

from splinebba_cli.report.blocks import (
    Block,
    Column,
    Facts,
    FigureBlock,
    Note,
    ProblemList,
    Report,
    Table,
    Tone,
    cell_text,
)
from splinebba_cli.report.markdown_text import markdown_prose, markdown_text

_ROWS = 25
_ALERTS: dict[Tone, str] = {"good": "TIP", "warning": "WARNING", "bad": "CAUTION", "neutral": "NOTE"}
_MARKS: dict[Tone, str] = {"good": " ✅", "warning": " ⚠️", "bad": " ❌", "neutral": ""}
_SEVERITIES = {"error": "❌ **Error**", "warning": "⚠️ **Warning**", "info": "ℹ️ **Info**"}


def render_markdown(report: Report) -> str:
    """The whole report as Markdown; the same report gives the same text.

    Long tables are cut, with the name of the file that has all rows; figures stand in report.html only.
    """
    lines = [
        f"# {markdown_text(report.title)}",
        "",
        markdown_text(report.subtitle),
        "",
        f"> [!{_ALERTS[report.verdict.tone]}]",
        f"> **{markdown_text(report.verdict.headline)}**",
        ">",
        f"> {markdown_text(report.verdict.detail)}",
        "",
        *_facts(report.key_facts),
    ]
    for section in report.sections:
        bodies = [body for block in section.blocks if (body := list(_block(block)))]
        if bodies:
            lines += ["", f"## {markdown_text(section.title)}"]
            for body in bodies:
                lines += ["", *body]
    return "\n".join(lines) + "\n"


def _block(block: Block) -> Iterable[str]:
    if isinstance(block, Facts):
        return _facts(block)
    if isinstance(block, Note):
        return [markdown_prose(block.text)]
    if isinstance(block, ProblemList):
        return _problems(block)
    if isinstance(block, FigureBlock):
        return []
    return _table(block)


def _facts(facts: Facts) -> list[str]:
    lines = ["| | | |", "|:--|--:|:--|"] if facts.items else []
    for fact in facts.items:
        value = f"{markdown_text(fact.value)}{_MARKS[fact.tone]}"
        lines.append(f"| {markdown_text(fact.label)} | {value} | {markdown_text(fact.note)} |")
    return lines


def _problems(problems: ProblemList) -> list[str]:
    if not problems.items:
        return ["None found."]
    lines = []
    for item in problems.items:
        lines.append(f"- {_SEVERITIES[item.severity]} {item.code}: {markdown_prose(item.sentence)}")
        if item.help:
            lines.append(f"  <br>→ {markdown_prose(item.help)}")
    return lines


def _table(table: Table) -> list[str]:
    rows = table.rows[:_ROWS]
    head = [markdown_text(column.heading) for column in table.columns]
    rule = ["--:" if column.numeric else ":--" for column in table.columns]
    lines = [f"**{markdown_text(table.caption)}**", "", _row(head), _row(rule)]
    for number, row in enumerate(rows):
        cells = [_cell(column, cell) for column, cell in zip(table.columns, row, strict=True)]
        if number in table.marked:
            cells[0] = f"⚠️ {cells[0]}"
        lines.append(_row(cells))
    if len(table.rows) > _ROWS:
        where = f"; all are in `{table.source}`" if table.source else ""
        lines += ["", f"The first {_ROWS} of {len(table.rows)} rows{where}."]
    words = [f"**{markdown_text(column.title)}**: {markdown_prose(column.help)}." for column in table.legend]
    words += [markdown_prose(table.note)] if table.note else []
    lines += ["", " ".join(words)] if words else []
    return _folded(table, lines) if table.folded else lines


def _folded(table: Table, lines: list[str]) -> list[str]:
    """A part that GitHub shows closed."""
    summary = f"<summary>{markdown_text(table.caption)} ({len(table.rows)} rows)</summary>"
    return ["<details>", summary, "", *lines[2:], "", "</details>"]


def _cell(column: Column, cell: str | float | int | None) -> str:
    return markdown_text(cell_text(column, cell))


def _row(cells: list[str]) -> str:
    return f"| {' | '.join(cells)} |"
