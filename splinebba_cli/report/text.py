"""report.txt: the report as plain text with aligned columns; and the summary on the console."""

from __future__ import annotations

import textwrap
import unicodedata
from collections.abc import Iterable

from splinebba_cli.report.blocks import (
    Block,
    Column,
    Facts,
    FigureBlock,
    Note,
    ProblemList,
    Report,
    Section,
    Table,
    cell_text,
)
from splinebba_cli.report.console import console_summary
from splinebba_cli.report.printable import one_line

__all__ = ["console_summary", "render_text"]

_WIDTH = 110
_ROWS = 2000
_FOLDED_ROWS = 60


def render_text(report: Report) -> str:
    """The whole report as text; the same report gives the same text."""
    title = one_line(report.title)
    lines = [title, "=" * _width(title), one_line(report.subtitle), ""]
    lines += [report.verdict.headline.upper()]
    lines += _wrapped(report.verdict.detail)
    lines += ["", *_facts(report.key_facts)]
    for section in report.sections:
        body = list(_section_body(section))
        if body:
            lines += ["", "", section.title, "-" * _width(section.title), *body]
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _section_body(section: Section) -> Iterable[str]:
    first = True
    for block in section.blocks:
        if isinstance(block, FigureBlock):
            continue
        if not first:
            yield ""
        first = False
        yield from _block(block)


def _block(block: Block) -> list[str]:
    if isinstance(block, Facts):
        return _facts(block)
    if isinstance(block, Note):
        return _wrapped(block.text)
    if isinstance(block, ProblemList):
        return _problems(block)
    if isinstance(block, Table):
        return _table(block)
    return []


def _facts(facts: Facts) -> list[str]:
    label = max((_width(fact.label) for fact in facts.items), default=0)
    value = max((_width(fact.value) for fact in facts.items if fact.note), default=0)
    lines = []
    for fact in facts.items:
        note = f"  ({fact.note})" if fact.note else ""
        text = f"{_pad(fact.label, label)}  {_pad(fact.value, value) if note else fact.value}{note}"
        lines.append(one_line(text))
    return lines


def _problems(problems: ProblemList) -> list[str]:
    if not problems.items:
        return ["None found."]
    lines: list[str] = []
    for item in problems.items:
        head = one_line(f"{item.severity} {item.code}: {item.sentence}")
        lines += textwrap.wrap(head, _WIDTH, subsequent_indent="    ", break_long_words=False)
        if item.help:
            lines += textwrap.wrap(
                one_line(f"help: {item.help}"),
                _WIDTH,
                initial_indent="    ",
                subsequent_indent="    ",
                break_long_words=False,
            )
    return lines


def _table(table: Table) -> list[str]:
    limit = _FOLDED_ROWS if table.folded else _ROWS
    shown = table.rows[:limit]
    mark = bool(table.marked)
    cells = [[cell_text(c, x) for c, x in zip(table.columns, row, strict=True)] for row in shown]
    cells = [[one_line(text) for text in row] for row in cells]
    widths = [
        max([_width(column.heading), *(_width(row[i]) for row in cells)])
        for i, column in enumerate(table.columns)
    ]
    lines = [
        f"{one_line(table.caption)}:",
        "",
        _row([c.heading for c in table.columns], table.columns, widths),
    ]
    lines.append("  ".join("-" * width for width in widths))
    for number, row in enumerate(cells):
        lines.append(_row(row, table.columns, widths) + (" *" if number in table.marked else ""))
    if len(table.rows) > limit:
        lines.append(f"… and {len(table.rows) - limit} more in {table.source}")
    if mark:
        lines.append("* deserves a look")
    for column in table.legend:
        lines += _wrapped(f"{column.title}: {column.help}")
    return lines + (_wrapped(table.note) if table.note else [])


def _row(texts: list[str], columns: tuple[Column, ...], widths: list[int]) -> str:
    return "  ".join(
        _pad(text, width, right=column.numeric)
        for text, column, width in zip(texts, columns, widths, strict=True)
    )


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(one_line(text), _WIDTH, break_long_words=False)


def _width(text: str) -> int:
    """Columns that a text takes on a screen."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text
    )


def _pad(text: str, width: int, *, right: bool = False) -> str:
    space = " " * max(0, width - _width(text))
    return space + text if right else text + space
