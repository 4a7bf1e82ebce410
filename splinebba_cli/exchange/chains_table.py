"""Chains in tables: a row for every point (x, y or row, col), or for every segment (x1, y1, x2, y2).

Columns ``image`` and ``chain`` are used where they are there.  Without `image` it has the name of the file; without
`chain` all points of an image are one chain, and every segment is one.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.traced_chains import TracedChain, TracingOptions
from splinebba_cli.project.diagnostics import Collector, Place, listing
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_cells import cells_of, separator_of
from splinebba_cli.project.tables import TableUnreadableError, table_from_text
from splinebba_cli.project.text_position import lines_of

SEGMENT = ("x1", "y1", "x2", "y2")
POINT = ("x", "y")
NAMES = ("image", "chain", *POINT, *SEGMENT)
OTHER_NAMES = {"col": "x", "column": "x", "row": "y"}  # of arrays
EXAMPLES = "`--columns x1,y1,x2,y2` for segments, `--columns x,y` or `--columns row,col` for points"


def chains_from_table(
    text: str, file: str, image: str, options: TracingOptions, collector: Collector
) -> list[TracedChain]:
    """Chains of a table; errors go to the collector.

    Parameters
    ----------
    image : str
        Of tables without the column ``image``.
    """
    try:
        table = _table(text, file, options, collector)
        names = _names(table, collector)
    except TableUnreadableError:
        return []
    images = table.texts(names["image"]) if "image" in names else [image] * table.rows
    ids = [word.strip() for word in table.columns[names["chain"]]] if "chain" in names else [""] * table.rows
    xy = [table.numbers(names[name]) for name in (SEGMENT if "x1" in names else POINT)]
    if "x1" in names:
        ends = np.stack(xy, axis=1).reshape(-1, 2, 2)
        return [
            TracedChain(images[row], ids[row], ends[row], table.place_of(row, names["x1"]))
            for row in range(table.rows)
        ]
    return _chains_of_points(table, images, ids, np.stack(xy, axis=1), names["x"])


def _chains_of_points(
    table: Table, images: list[str], ids: list[str], xy: FloatArray, x: str
) -> list[TracedChain]:
    rows: dict[tuple[str, str], list[int]] = {}
    for row, key in enumerate(zip(images, ids, strict=True)):
        rows.setdefault(key, []).append(row)
    return [
        TracedChain(image, id, xy[taken], table.place_of(taken[0], x)) for (image, id), taken in rows.items()
    ]


def _table(text: str, file: str, options: TracingOptions, collector: Collector) -> Table:
    """The table; names that the options give stand in the place of those of a header."""
    first = _first_row(text)
    if options.columns is None:
        if first and all(map(_is_number, first)):
            message = f"the table has no header: nothing says what its {len(first)} columns are"
            collector.error("SBB402", message, Place(file, 1), EXAMPLES)
            raise TableUnreadableError
        return table_from_text(text, file=file, collector=collector, columns=None)
    columns = [*options.columns, *["-"] * (len(first) - len(options.columns))]
    return table_from_text(
        text, file=file, collector=collector, columns=columns, header=_is_header(first, columns)
    )


def _is_header(first: list[str], columns: list[str]) -> bool:
    """Whether a first row has words where coordinates should be."""
    cells = dict(zip(columns, first, strict=False))
    coordinates = [name for name in cells if name in (*POINT, *SEGMENT, *OTHER_NAMES)]
    return not all(_is_number(cells[name]) for name in coordinates)


def _names(table: Table, collector: Collector) -> dict[str, str]:
    """Names of our columns among those of the table."""
    names: dict[str, str] = {}
    for name in table.columns:
        ours = known_column(name)
        if ours:
            names.setdefault(ours, name)
    wanted = SEGMENT if any(name in names for name in SEGMENT) else POINT
    lacking = [name for name in wanted if name not in names]
    if lacking:
        message = f"the table has no column {listing(lacking)}"
        help = f"it has {listing(table.columns, 20)}; name its columns in their order: {EXAMPLES}"
        collector.error("SBB402", message, table.head, help)
        raise TableUnreadableError
    return names


def known_column(name: str) -> str:
    """Our name of a column; empty of one that is none of ours."""
    ours = OTHER_NAMES.get(name.lower(), name.lower())
    return ours if ours in NAMES else ""


def _first_row(text: str) -> list[str]:
    content = (line for line in lines_of(text) if line.strip() and not line.strip().startswith("#"))
    line = next(content, "")
    return [cell.strip() for cell in cells_of(line, separator_of(line, "auto"))] if line else []


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
