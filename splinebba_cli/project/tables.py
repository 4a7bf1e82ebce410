"""Tables: side files (CSV, Parquet) and rows in the project file, read by columns.

Numbers are checked as whole columns; only where that fails, single rows are looked at, and the first bad ones
are reported with file, line and column.  Identifiers stay texts.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.project.diagnostics import SHOWN_PER_KIND, Collector, Place
from splinebba_cli.project.scalars import parse_number, parse_sigma

_SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}
_BLANKS = {"", "-", "na", "NA"}
_YES, _NO = {"yes", "true", "1", "", "-"}, {"no", "false", "0"}


class TableUnreadableError(Exception):
    """The table cannot be used at all; the collector holds the reason."""


@dataclass
class Table:
    """Columns of texts (CSV, inline) or arrays (Parquet), and where every row stands."""

    file: str
    columns: Mapping[str, Sequence[Any]]
    rows: int
    place_of: Callable[[int, str], Place]  # row, column -> place
    collector: Collector
    head: Place
    _read: dict[tuple[str, str], FloatArray] = field(default_factory=dict)  # read (and reported) once

    def has(self, name: str) -> bool:
        """Whether the table has a column."""
        return name in self.columns

    def texts(self, name: str) -> list[str]:
        """A column of identifiers; an empty one is an error."""
        values = [str(value).strip() for value in self.columns[name]]
        if "" in values:
            bad = [row for row, value in enumerate(values) if not value]
            self._report(bad, name, lambda row: f"no `{name}`")
        return values

    def numbers(self, name: str, *, optional: bool = False) -> FloatArray:
        """A column of finite numbers, (n,); where `optional`, an empty field (or ``-``) is NaN."""
        return self._once("optional" if optional else "number", name)

    def sigmas(self, name: str) -> FloatArray:
        """A column of standard deviations (number, fixed, free), (n,); an empty field is NaN."""
        return self._once("sigma", name)

    def _once(self, kind: str, name: str) -> FloatArray:
        if (kind, name) not in self._read:
            read = self._sigmas(name) if kind == "sigma" else self._numbers(name, kind == "optional")
            self._read[kind, name] = read
        return self._read[kind, name]

    def _numbers(self, name: str, optional: bool) -> FloatArray:
        raw = self.columns[name]
        if isinstance(raw, np.ndarray):
            values = raw.astype(np.float64)
            bad = np.flatnonzero(~np.isfinite(values) & ~(np.isnan(values) & optional))
            self._report(bad, name, lambda row: f"`{name}` is not a finite number")
            return values
        try:
            values = np.array(list(map(float, raw)), dtype=np.float64)
            if np.isfinite(values).all() and not any(map("_".__eq__, set("".join(raw)))):
                return values
        except (ValueError, TypeError):
            pass
        return self._one_by_one(name, parse_number, blank=math.nan if optional else None)

    def _sigmas(self, name: str) -> FloatArray:
        raw = self.columns[name]
        if isinstance(raw, np.ndarray):
            values = raw.astype(np.float64)
            self._report(np.flatnonzero(values < 0.0), name, lambda row: f"`{name}` is negative", "SBB309")
            return values
        try:
            values = np.array(list(map(float, raw)), dtype=np.float64)
            if np.isfinite(values).all() and (values > 0.0).all():
                return values
        except (ValueError, TypeError):
            pass
        return self._one_by_one(name, parse_sigma, blank=math.nan)

    def integers(self, name: str) -> IntArray:
        """A column of whole numbers >= 0, (n,); an empty field is -1."""
        values = self.numbers(name, optional=True)
        missing = np.isnan(values)
        whole = np.where(missing, -1.0, values)
        bad = np.flatnonzero(~missing & ((whole != np.rint(whole)) | (whole < 0)))
        self._report(bad, name, lambda row: f"`{name}` is not a whole number >= 0")
        return np.asarray(np.where(np.abs(whole) < 2**53, whole, -1.0).astype(np.int64))

    def excluded(self) -> BoolArray:
        """Rows whose column `use` says no, (n,); without the column all are used, an empty field is yes."""
        out = np.zeros(self.rows, dtype=bool)
        if not self.has("use"):
            return out
        words = [str(value).strip().lower() for value in self.columns["use"]]
        bad = [row for row, word in enumerate(words) if word not in _YES and word not in _NO]
        self._report(bad, "use", lambda row: f"`use` is yes or no, not `{words[row]}`")
        out[:] = [word in _NO for word in words]
        return out

    def _one_by_one(self, name: str, parse: Callable[[Any], float], blank: float | None) -> FloatArray:
        values = np.full(self.rows, np.nan)
        bad: dict[int, str] = {}
        for row, text in enumerate(self.columns[name]):
            text = str(text).strip()
            if blank is not None and text in _BLANKS:
                values[row] = blank
                continue
            try:
                values[row] = parse(text)
            except ValueError as error:
                values[row] = 1.0  # anything: an error is reported
                bad[row] = f"no `{name}`" if not text else f"`{name}`: {error}"
        sigma = parse is parse_sigma
        for row in list(bad)[:SHOWN_PER_KIND]:
            code = "SBB309" if sigma and "positive;" in bad[row] else "SBB403"
            self._report([row], name, bad.__getitem__, code)
        self._count_more(name, len(bad) - SHOWN_PER_KIND)
        return values

    def _report(
        self, rows: Sequence[int] | IntArray, name: str, message: Callable[[int], str], code: str = "SBB403"
    ) -> None:
        for row in rows[:SHOWN_PER_KIND]:
            place = self.place_of(int(row), name)
            where = "" if place.line is not None else f" (row {int(row) + 1})"
            self.collector.error(
                code, message(int(row)) + where, place, kind=f"bad values in column `{name}`"
            )
        self._count_more(name, len(rows) - SHOWN_PER_KIND, code)

    def _count_more(self, name: str, more: int, code: str = "SBB403") -> None:
        if more > 0:
            self.collector.count_more(code, self.file, f"bad values in column `{name}`", more)


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
    """
    lines = text.splitlines()
    content, numbers = _content_lines(text, lines)
    head = declared_at or Place(file, first_line + 1, 1)
    if not content:
        collector.error("SBB405", "the table has no rows", head)
        raise TableUnreadableError
    separator = _separator(content[0], delimiter)
    has_header = columns is None if header is None else header
    body = content[1:] if has_header else content
    where = _Positions(
        file,
        numbers[1:] if has_header else numbers,
        first_line,
        source_lines if source_lines is not None else lines,
        separator,
    )
    names = list(columns) if columns is not None else [cell.strip() for cell in _cells(content[0], separator)]
    _check_names(names, Place(file, numbers[0] + first_line + 1, 1, len(content[0]), content[0]), collector)
    if not body:
        collector.error("SBB405", "the table has a header but no rows", head)
        raise TableUnreadableError
    _check_widths(body, len(names), where, collector, columns is not None)
    by_column = dict(zip(names, _columns(body, separator, len(names)), strict=True))
    by_column.pop("-", None)

    def place_of(row: int, name: str) -> Place:
        return where.of(row, names.index(name) if name in names else 0)

    return Table(file, by_column, len(body), place_of, collector, head)


@dataclass(frozen=True)
class _Positions:
    """Where the fields of a table stand in its file."""

    file: str
    numbers: Sequence[int]  # line of every row, from 0, within the text
    first_line: int
    lines: Sequence[str]  # of the file
    separator: str | None

    def of(self, row: int, column: int | None) -> Place:
        """Place of a field, or of a whole row."""
        line = self.numbers[row] + self.first_line
        snippet = self.lines[line] if line < len(self.lines) else ""
        start, length = (0, len(snippet)) if column is None else _field_span(snippet, self.separator, column)
        return Place(self.file, line + 1, start + 1, length, snippet)


def _content_lines(text: str, lines: list[str]) -> tuple[list[str], Sequence[int]]:
    """Lines with content and their numbers."""
    if "#" not in text and all(map(str.strip, lines)):
        return lines, range(len(lines))
    numbers = [i for i, line in enumerate(lines) if (s := line.strip()) and not s.startswith("#")]
    return [lines[i] for i in numbers], numbers


def _separator(line: str, delimiter: str) -> str | None:
    """The character between fields, None for blanks."""
    if delimiter == "auto":
        return next((s for s in "\t;," if s in line), None)
    return _SEPARATORS.get(delimiter)


def _cells(line: str, separator: str | None) -> list[str]:
    """Fields of one line; an unclosed quotation makes it one field."""
    if separator is None:
        return line.split()
    if '"' not in line:
        return line.split(separator)
    rows = list(csv.reader([line, ""], delimiter=separator, skipinitialspace=True))
    return rows[0] if len(rows) == 2 or line.count('"') % 2 == 0 else [line]


def _columns(lines: list[str], separator: str | None, width: int) -> list[Sequence[str]]:
    """Columns of lines that all have `width` fields."""
    if separator is not None and not any('"' in line for line in lines):
        fields = separator.join(lines).split(separator)
    else:
        fields = [cell for line in lines for cell in _cells(line, separator)]
    return [fields[number::width] for number in range(width)]


def _field_span(line: str, separator: str | None, index: int) -> tuple[int, int]:
    """Start and length of a field within its line."""
    position = 0
    if separator is None:
        for _ in range(index + 1):
            while position < len(line) and line[position].isspace():
                position += 1
            start = position
            while position < len(line) and not line[position].isspace():
                position += 1
        return start, max(1, position - start)
    fields = line.split(separator)
    if index >= len(fields):
        return len(line), 1
    start = sum(len(cell) + 1 for cell in fields[:index])
    cell = fields[index]
    lead = len(cell) - len(cell.lstrip()) if cell.strip() else 0
    return start + lead, max(1, len(cell.strip()))


def _check_names(names: list[str], place: Place, collector: Collector) -> None:
    twice = sorted({name for name in names if name != "-" and names.count(name) > 1})
    if twice:
        collector.error("SBB402", f"two columns are named `{twice[0]}`", place)
        raise TableUnreadableError


def _check_widths(
    lines: list[str], width: int, where: _Positions, collector: Collector, declared: bool
) -> None:
    """Every row has as many fields as there are columns."""
    separator = where.separator
    if separator is None or any('"' in line for line in lines):
        counts = [len(_cells(line, separator)) for line in lines]
    else:
        counts = [line.count(separator) + 1 for line in lines]
    bad = [row for row, count in enumerate(counts) if count != width]
    for row in bad[:SHOWN_PER_KIND]:
        expected = "declared columns" if declared else "columns of the header"
        message = f"{counts[row]} fields in a row, {width} {expected}"
        collector.error("SBB404", message, where.of(row, None))
    if bad:
        if len(bad) > SHOWN_PER_KIND:
            collector.count_more("SBB404", where.file, "rows with a wrong number of fields", len(bad))
        raise TableUnreadableError


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


def table_from_parquet(path: Path, *, file: str, collector: Collector, declared_at: Place) -> Table:
    """Read a Parquet file; needs pyarrow."""
    try:
        from pyarrow import parquet  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        help = "install `splinebba[parquet]`, or write the table as CSV"
        collector.error("SBB406", "Parquet needs pyarrow, which is not installed", declared_at, help)
        raise TableUnreadableError from None
    try:
        content = parquet.read_table(io.BytesIO(path.read_bytes()))
    except Exception as error:  # noqa: BLE001 — pyarrow raises its own kinds
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        collector.error("SBB401", f"`{file}` cannot be read: {reason}", declared_at)
        raise TableUnreadableError from None
    columns: dict[str, Sequence[Any]] = {}
    for name in content.column_names:
        column = content.column(name)
        kind = str(column.type)
        if kind.startswith(("double", "float", "halffloat")):
            columns[name] = column.to_numpy()
        elif kind.startswith(("int", "uint")) and column.null_count == 0:
            columns[name] = [str(value) for value in column.to_pylist()]
        else:
            columns[name] = ["" if value is None else str(value) for value in column.to_pylist()]
    if content.num_rows == 0:
        collector.error("SBB405", "the table has no rows", declared_at)
        raise TableUnreadableError

    def place_of(row: int, name: str) -> Place:
        return Place(file)

    return Table(file, columns, content.num_rows, place_of, collector, declared_at)
