"""Tables: side files (CSV, Parquet) and rows in the project file, read by columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from splinebba_cli.project.diagnostics import SHOWN_PER_KIND, Collector, Place
from splinebba_cli.project.regular_table import Columns, LinesOfBytes
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_cells import cells_of, field_span, separator_of, unclosed_quotation
from splinebba_cli.project.text_position import lines_of


class TableUnreadableError(Exception):
    """The table cannot be used at all; the collector holds the reason."""


def table_from_text(
    text: str,
    *,
    file: str,
    collector: Collector,
    columns: Sequence[str] | None,
    header: bool | None = None,
    delimiter: str = "auto",
    first_line: int = 0,
    source_lines: Sequence[str] | None = None,
    declared_at: Place | None = None,
    whole: Place | None = None,
) -> Table:
    """Read rows of text.

    Parameters
    ----------
    text : str
        Rows, one a line; empty lines and lines that begin with ``#`` are passed over.
    columns : sequence of str or None
        Names in their order (``-`` for one that is not used); None: the first row names them.
    header : bool or None
        Whether the first row is a header; None: only if `columns` is None.
    first_line : int
        Number (from 0) of the line of the file in which `text` begins.
    source_lines : sequence of str or None
        Lines of the file for snippets; None: `text` is the file.
    declared_at : Place or None
        Where the project names the table.
    whole : Place or None
        Where the text as a whole stands, if its rows are no lines of the file.
    """
    lines = lines_of(text)
    content, numbers = _content_lines(text, lines)
    head = declared_at or Place(file, first_line + 1, 1)
    if not content:
        collector.error("SBB405", "the table has no rows", head)
        raise TableUnreadableError
    separator = separator_of(content[0], delimiter)
    has_header = columns is None if header is None else header
    body = content[1:] if has_header else content
    where = _Positions(
        file,
        numbers[1:] if has_header else numbers,
        first_line,
        source_lines if source_lines is not None else lines,
        separator,
        whole,
    )
    names = (
        list(columns) if columns is not None else [cell.strip() for cell in cells_of(content[0], separator)]
    )
    top = replace(where, numbers=numbers)
    _check_names(names, top, collector)
    if not body:
        collector.error("SBB405", "the table has a header but no rows", head)
        raise TableUnreadableError
    _check_widths(body, len(names), where, collector, columns is not None)
    by_column = dict(zip(names, _columns(body, separator, len(names)), strict=True))
    by_column.pop("-", None)

    def place_of(row: int, name: str) -> Place:
        return where.of(row, names.index(name) if name in names else 0)

    return Table(file, by_column, len(body), place_of, collector, head)


def table_from_columns(
    columns: Columns,
    names: Sequence[str],
    content: bytes,
    *,
    file: str,
    collector: Collector,
    header: bool,
    separator: str,
    declared_at: Place,
) -> Table:
    """A table whose columns were read as a whole; `names` are those of all columns in their order."""
    rows = len(next(iter(columns.values())))
    where = _Positions(file, range(int(header), int(header) + rows), 0, LinesOfBytes(content), separator)
    everything: dict[str, Sequence[Any]] = {name: () for name in names if name != "-"}

    def place_of(row: int, name: str) -> Place:
        return where.of(row, names.index(name) if name in names else 0)

    everything.update({name: cast(Any, column) for name, column in columns.items()})
    return Table(file, everything, rows, place_of, collector, declared_at)


@dataclass(frozen=True)
class _Positions:
    """Where the fields of a table stand in its file."""

    file: str
    numbers: Sequence[int]  # line of every row, from 0, within the text
    first_line: int
    lines: Sequence[str]  # of the file
    separator: str | None
    whole: Place | None = None  # of rows that are no lines of the file

    def of(self, row: int, column: int | None) -> Place:
        """Place of a field, or of a whole row."""
        if self.whole is not None:
            return self.whole
        line = self.numbers[row] + self.first_line
        snippet = self.lines[line] if line < len(self.lines) else ""
        start, length = (0, len(snippet)) if column is None else field_span(snippet, self.separator, column)
        return Place(self.file, line + 1, start + 1, length, snippet)


def _content_lines(text: str, lines: list[str]) -> tuple[list[str], Sequence[int]]:
    """Lines with content and their numbers."""
    if "#" not in text and all(map(str.strip, lines)):
        return lines, range(len(lines))
    numbers = [i for i, line in enumerate(lines) if (s := line.strip()) and not s.startswith("#")]
    return [lines[i] for i in numbers], numbers


def _columns(lines: list[str], separator: str | None, width: int) -> list[Sequence[str]]:
    """Columns of lines that all have `width` fields."""
    if separator is not None and not any('"' in line for line in lines):
        fields = separator.join(lines).split(separator)
    else:
        fields = [cell for line in lines for cell in cells_of(line, separator)]
    return [fields[number::width] for number in range(width)]


def _check_names(names: list[str], top: _Positions, collector: Collector) -> None:
    """No two columns have one name."""
    for number, name in enumerate(names):
        if name != "-" and name in names[:number]:
            first = top.of(0, names.index(name)).column
            help = f"the first one is at column {first}"
            collector.error("SBB402", f"two columns are named `{name}`", top.of(0, number), help)
            raise TableUnreadableError


def _check_widths(
    lines: list[str], width: int, where: _Positions, collector: Collector, declared: bool
) -> None:
    """Every row has as many fields as there are columns."""
    separator = where.separator
    if separator is None or any('"' in line for line in lines):
        counts = [len(cells_of(line, separator)) for line in lines]
    else:
        counts = [line.count(separator) + 1 for line in lines]
    bad = [row for row, count in enumerate(counts) if count != width]
    _check_quotations([(row, lines[row]) for row in bad], where, collector)
    for row in bad[:SHOWN_PER_KIND]:
        expected = "declared columns" if declared else "columns of the header"
        message = f"{counts[row]} fields in a row, {width} {expected}"
        collector.error(
            "SBB404", message, where.of(row, None), _help_for_width(counts[row], width, separator)
        )
    if bad:
        if len(bad) > SHOWN_PER_KIND:
            collector.count_more("SBB404", where.file, "rows with a wrong number of fields", len(bad))
        raise TableUnreadableError


def _check_quotations(rows: list[tuple[int, str]], where: _Positions, collector: Collector) -> None:
    """A row in which a quotation has no end says so instead of its number of fields."""
    for row, line in rows:
        if unclosed_quotation(line, where.separator) is None:
            continue
        whole = where.of(row, None)
        column = unclosed_quotation(whole.snippet, where.separator) or 0
        place = replace(whole, column=column + 1, length=len(whole.snippet) - column)
        help = 'a field ends in the line in which it begins; write `""` for a mark within quotation marks'
        collector.error("SBB410", "a quotation mark without its end", place, help)
        raise TableUnreadableError


def _help_for_width(count: int, width: int, separator: str | None) -> str:
    if 1 < count < width and separator is not None:
        return (
            f"an empty field keeps its `{separator}`" if separator != "\t" else "an empty field keeps its tab"
        )
    if count == 1 and width > 1 and separator is not None:
        return (
            f"the first row has `{separator}` between its fields" if separator != "\t" else "tabs are missing"
        )
    if count > width and separator == ",":
        return "a comma separates fields: write decimals with a point, or choose another `delimiter`"
    if count > width and separator is None:
        return "blanks separate fields: a field that holds one needs another `delimiter` and quotation marks"
    return ""


def table_from_rows(
    rows: Sequence[Sequence[str]],
    *,
    file: str,
    collector: Collector,
    columns: Sequence[str],
    place_of_cell: Callable[[int, int | None], Place],
    declared_at: Place,
) -> Table:
    """A table of rows written as lists in the project file."""
    names = list(columns)
    if not rows:
        collector.error("SBB405", "the table has no rows", declared_at)
        raise TableUnreadableError
    bad = [number for number, row in enumerate(rows) if len(row) != len(names)]
    for number in bad[:SHOWN_PER_KIND]:
        message = f"{len(rows[number])} values in a row, {len(names)} columns ({', '.join(names)})"
        collector.error("SBB404", message, place_of_cell(number, None))
    if bad:
        raise TableUnreadableError

    def place_of(row: int, name: str) -> Place:
        return place_of_cell(row, names.index(name) if name in names else None)

    by_column = dict(zip(names, zip(*rows, strict=True), strict=True))
    by_column.pop("-", None)
    return Table(file, by_column, len(rows), place_of, collector, declared_at)
