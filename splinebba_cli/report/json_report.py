"""report.json: the report as data, for programs that lay it out themselves.

    {"format": "splinebba-report/1", "title": …, "subtitle": …,
     "verdict": {"tone", "headline", "detail"}, "key_facts": [fact, …],
     "sections": [{"id", "title", "blocks": [block, …]}, …]}

A block has a `kind`:

- ``facts``: ``items`` of ``{label, value, note, tone}``, and ``number`` with its ``unit`` where the value is one
  number: with all digits where they are known, otherwise as it is shown
- ``table``: ``caption``, ``columns`` of ``{title, unit, decimals, numeric, help}``, ``rows`` of raw numbers in the unit
  of their column (all digits; ``null``: no value), ``marked`` (numbers of the rows that deserve a look), ``source``,
  ``note``
- ``problems``: ``items`` of ``{code, severity, subject, message, help}``
- ``note``: ``text``
- ``figure``: ``figure``, ``subject``, ``caption``, ``alt``; the drawing itself is in report.html
"""

from __future__ import annotations

import math
import re
from dataclasses import asdict
from typing import Any

from splinebba_cli.output.json_text import json_text
from splinebba_cli.report.blocks import (
    Block,
    Cell,
    Fact,
    Facts,
    FigureBlock,
    Note,
    ProblemList,
    Report,
    Table,
)

FORMAT = "splinebba-report/1"
_ONE_NUMBER = re.compile(r"(-?\d+(?:\.\d+)?)(?: ?([^\s\d]+))?")


def render_json(report: Report) -> str:
    """The whole report as JSON; the same report gives the same text, and no number in it is NaN or infinite."""
    content = {
        "format": FORMAT,
        "title": report.title,
        "subtitle": report.subtitle,
        "verdict": asdict(report.verdict),
        "key_facts": [_fact(fact) for fact in report.key_facts.items],
        "sections": [
            {"id": section.id, "title": section.title, "blocks": [_block(block) for block in section.blocks]}
            for section in report.sections
        ],
    }
    return json_text(content)


def _block(block: Block) -> dict[str, Any]:
    if isinstance(block, Facts):
        return {"kind": "facts", "items": [_fact(fact) for fact in block.items]}
    if isinstance(block, Table):
        return _table(block)
    if isinstance(block, ProblemList):
        return {"kind": "problems", "items": [asdict(item) for item in block.items]}
    if isinstance(block, Note):
        return {"kind": "note", "text": block.text}
    return _figure(block)


def _figure(block: FigureBlock) -> dict[str, Any]:
    return {"kind": "figure", **asdict(block)}


def _fact(fact: Fact) -> dict[str, Any]:
    text = {"label": fact.label, "value": fact.value, "note": fact.note, "tone": fact.tone}
    if fact.number is not None:
        return {**text, "number": _finite(fact.number), "unit": fact.unit}
    shown = _ONE_NUMBER.fullmatch(fact.value)
    if shown is None:
        return text
    digits, unit = shown.groups("")
    return {**text, "number": float(digits) if "." in digits else int(digits), "unit": unit}


def _table(table: Table) -> dict[str, Any]:
    return {
        "kind": "table",
        "caption": table.caption,
        "columns": [asdict(column) for column in table.columns],
        "rows": [[_finite(cell) for cell in row] for row in table.rows],
        "marked": sorted(table.marked),
        "source": table.source,
        "note": table.note,
    }


def _finite(cell: Cell) -> Cell:
    return None if isinstance(cell, float) and not math.isfinite(cell) else cell
