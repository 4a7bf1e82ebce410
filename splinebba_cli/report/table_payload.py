"""Rows of a long table as compact JSON inside of the page, from which its script makes the rows that are looked at.

    {"columns": [[1.25, null, …], {"words": ["a", "b"], "at": [0, 0, 1, …]}, …], "marked": [4, 17]}

Column by column: numbers rounded as they are shown, texts as words and where they stand. The table sorts and
filters by what the reader sees.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

from splinebba_cli.report.blocks import Cell, Column, Table

_encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode
# no end tag and no comment may be read into the script element; the rest of JSON is safe in it
_IN_SCRIPT = str.maketrans(
    {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"}
)


def table_payload(table: Table, limit: int) -> str:
    """The first `limit` rows of a table as JSON that may stand in a ``<script>`` element.

    Parameters
    ----------
    table : Table
    limit : rows at most

    Returns
    -------
    str
        JSON without ``<``, ``>`` and ``&``.
    """
    rows = table.rows[:limit]
    cells: Iterable[Sequence[Cell]] = zip(*rows, strict=True)
    columns = ",".join(map(_column, table.columns, cells))
    marked = _encode(sorted(row for row in table.marked if row < limit))
    return f'{{"columns":[{columns}],"marked":{marked}}}'.translate(_IN_SCRIPT)


def _column(column: Column, cells: Sequence[Cell]) -> str:
    if not column.numeric:
        return _words(cells)
    places = column.decimals
    if places is None:
        return _encode([_plain(cell) for cell in cells])
    return f"[{','.join(_rounded(cell, places) for cell in cells)}]"


def _plain(cell: Cell) -> Cell:
    """A whole number or a text as it is, another number to six digits."""
    if isinstance(cell, float):
        return float(f"{cell:.6g}") if math.isfinite(cell) else f"{cell:g}"
    return cell


def _rounded(cell: Cell, places: int) -> str:
    """A number as JSON, no longer than it is shown: ``1.250`` is ``1.25``."""
    if cell is None:
        return "null"
    if isinstance(cell, str) or not math.isfinite(cell):
        return _encode(str(cell))
    text = f"{cell:.{places}f}"
    if places:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _words(cells: Sequence[Cell]) -> str:
    """Texts: every word once, and its number for every row."""
    place: dict[str, int] = {}
    at = [None if cell is None else place.setdefault(str(cell), len(place)) for cell in cells]
    content: dict[str, Any] = {"words": list(place), "at": at}
    return _encode(content)
