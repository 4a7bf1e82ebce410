"""Digitised lines in a table: columns x, y, z, and one that names the line where there are several."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.digitised_lines import DEGREES_HELP, DigitisedLine, ReadingOptions
from splinebba_cli.project.diagnostics import Collector, Place, listing, suggestion
from splinebba_cli.project.scalars import parse_number
from splinebba_cli.project.table import Table
from splinebba_cli.project.tables import TableUnreadableError, table_from_text

XYZ = ("x", "y", "z")
ID_COLUMNS = ("spline", "id", "name")
DEGREE_COLUMNS = ("lon", "long", "longitude", "lat", "latitude")


def lines_from_csv(
    text: str, file: str, options: ReadingOptions, collector: Collector
) -> list[DigitisedLine]:
    """Lines of a table; errors go to the collector.

    The first row is a header unless all its fields are numbers.  Names of columns that the options give are then those
    of x, y, z and, as the fourth, of the line; without a header they are the columns in their order, from
    x, y, z, spline, and ``-`` for one that is not used.
    """
    try:
        table, names = _table(text, file, options, collector)
        xyz = _coordinates(table, names, options, collector)
    except TableUnreadableError:
        return []
    if collector.has_errors:
        return []
    if "spline" not in names:
        return [DigitisedLine("", xyz)]
    rows: dict[str, list[int]] = {}
    for row, id in enumerate(table.texts(names["spline"])):
        rows.setdefault(id, []).append(row)
    return [DigitisedLine(id, xyz[taken]) for id, taken in rows.items()]


def _table(
    text: str, file: str, options: ReadingOptions, collector: Collector
) -> tuple[Table, dict[str, str]]:
    """The table, and its names of our columns."""
    columns = None
    if not _has_header(text):
        columns = options.columns or XYZ
        if options.columns is None and options.height is not None and _width(text) == 2:
            columns = XYZ[:2]
        unknown = [name for name in columns if name not in (*XYZ, *ID_COLUMNS, "-")]
        if unknown:
            known = listing((*XYZ, "spline", "-"))
            message = f"the table has no header, and `{unknown[0]}` is none of its columns"
            collector.error("SBB402", message, Place(file, 1), f"columns are {known}")
            raise TableUnreadableError
    table = table_from_text(text, file=file, collector=collector, columns=columns)
    if columns is None and options.columns is not None:
        return table, _chosen(table, options.columns, collector)
    by_small_name = {name.lower(): name for name in table.columns}
    names = {name: by_small_name[name] for name in XYZ if name in by_small_name}
    found = next((name for name in ID_COLUMNS if name in by_small_name), None)
    if found is not None:
        names["spline"] = by_small_name[found]
    degrees = [name for name in DEGREE_COLUMNS if name in by_small_name]
    if degrees and not {"x", "y"} <= set(names):
        message = f"column `{by_small_name[degrees[0]]}` holds degrees, not metres"
        collector.error("SBB321", message, table.head, DEGREES_HELP.partition(";")[0])
        raise TableUnreadableError
    return table, names


def _has_header(text: str) -> bool:
    first = _first_row(text)
    return not all(_is_number(cell) for cell in first)


def _width(text: str) -> int:
    return len(_first_row(text))


def _first_row(text: str) -> list[str]:
    for line in text.splitlines():
        if line.strip() and not line.strip().startswith("#"):
            separator = next((s for s in "\t;," if s in line), None)
            return [cell.strip() for cell in line.split(separator)]
    return []


def _is_number(text: str) -> bool:
    try:
        parse_number(text)
    except ValueError:
        return text.lower() in ("nan", "inf", "-inf")
    return True


def _chosen(table: Table, columns: tuple[str, ...], collector: Collector) -> dict[str, str]:
    """Columns of the header that the options name."""
    ours = (*XYZ, "spline") if len(columns) > 2 else XYZ[:2]
    if not 2 <= len(columns) <= 4:
        message = (
            f"{len(columns)} columns chosen; they are those of x, y, z and, if there is one, of the line"
        )
        collector.error("SBB402", message, table.head)
        raise TableUnreadableError
    for name in columns:
        if not table.has(name):
            help = suggestion(name, table.columns) or f"it has {listing(table.columns, 20)}"
            collector.error("SBB402", f"`{table.file}` has no column `{name}`", table.head, help)
            raise TableUnreadableError
    return dict(zip(ours, columns, strict=False))


def _coordinates(
    table: Table, names: dict[str, str], options: ReadingOptions, collector: Collector
) -> FloatArray:
    missing = [name for name in XYZ if name not in names]
    if missing == ["z"] and options.height is not None:
        missing = []
    elif missing == ["z"]:
        help = "`--z METRES` gives all points this height; `--columns` names other columns"
        collector.error("SBB322", f"`{table.file}` has no heights: no column `z`", table.head, help)
    elif missing:
        help = f"it has {listing(table.columns, 20)}; `--columns` names those of x, y and z"
        collector.error("SBB402", f"`{table.file}` has no column {listing(missing)}", table.head, help)
    if missing:
        raise TableUnreadableError
    columns = [table.numbers(names[name]) for name in XYZ if name in names]
    if "z" not in names:
        columns.append(np.full(table.rows, options.height))
    return np.stack(columns, axis=1)
