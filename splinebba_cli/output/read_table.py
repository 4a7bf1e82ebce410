"""Tables of a result folder read back, and those in memory as they would be read back."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import TextIO

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.output.columns import FORM, Column, Table, imported_pyarrow, printed
from splinebba_cli.output.number_text import rounded
from splinebba_cli.project.labels import Labels


class ReadTable(Mapping[str, Sequence[str]]):
    """Columns of text, or of numbers by :meth:`numbers`.

    Parameters
    ----------
    columns : mapping
        Texts, or columns of numbers that are written as they say.
    """

    def __init__(self, columns: Mapping[str, Sequence[str] | Column]) -> None:
        self._columns = dict(columns)
        self._parsed: dict[str, FloatArray] = {}  # of texts, which take much longer than they fill memory

    def __getitem__(self, name: str) -> Sequence[str]:
        column = self._columns[name]
        if isinstance(column, Column):
            values = np.asarray(column.values)
            if values.dtype.kind in "iu":
                return list(map(str, values.tolist()))
            return printed(values + 0.0, column.decimals) if len(values) else []
        return column

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        for column in self._columns.values():
            return len(column.values) if isinstance(column, Column) else len(column)
        return 0

    def where(self, name: str, keep: Callable[[str], bool]) -> ReadTable:
        """The rows whose field of a column is wanted; all where the table has no such column."""
        if name not in self._columns:
            return self
        wanted = _wanted(self[name], keep)
        if wanted.all():
            return self
        return ReadTable({key: _some(column, wanted) for key, column in self._columns.items()})

    def numbers(self, name: str) -> FloatArray:
        """A column as floats, NaN where empty; all NaN where the table has no such column."""
        column = self._columns.get(name)
        if column is None:
            return np.full(self.rows, np.nan)
        if isinstance(column, Column):
            return _numbers(column)
        if name not in self._parsed:
            self._parsed[name] = _parsed(column)
            self._parsed[name].setflags(write=False)
        return self._parsed[name]


def _parsed(texts: Sequence[str]) -> FloatArray:
    return np.array([text or "nan" for text in texts], dtype=np.float64)


def _numbers(column: Column) -> FloatArray:
    """The numbers of a column as they are read back from its text."""
    values = np.asarray(column.values, dtype=np.float64)
    form = FORM.fullmatch(column.decimals or "")
    if column.decimals is None:
        return np.where(np.isfinite(values), values + 0.0, np.nan)
    if form is not None and form[2] == "f":
        return rounded(values, int(form[1]))
    return _parsed(printed(values, column.decimals)) if len(values) else values


def _wanted(texts: Sequence[str], keep: Callable[[str], bool]) -> BoolArray:
    if isinstance(texts, Labels):
        return np.array([keep(name) for name in texts.names], dtype=bool)[texts.number]
    found = {text: keep(text) for text in set(texts)}
    return np.fromiter(map(found.__getitem__, texts), dtype=bool, count=len(texts))


def _some(column: Sequence[str] | Column, wanted: BoolArray) -> Sequence[str] | Column:
    if isinstance(column, Column):
        return Column(column.name, np.asarray(column.values)[wanted], column.decimals)
    if isinstance(column, Labels):
        return Labels(column.names, column.number[wanted])
    return [column[row] for row in np.flatnonzero(wanted).tolist()]


def as_read(table: Table, columns: Sequence[str] | None = None) -> ReadTable:
    """A table as :func:`read_table` gives it back; `columns` as there."""
    return ReadTable(
        {
            column.name: column if isinstance(column.values, np.ndarray) else column.values
            for column in table.columns
            if columns is None or column.name in columns
        }
    )


def read_table(folder: Path, name: str, columns: Sequence[str] | None = None) -> ReadTable:
    """Read ``<name>.csv`` or ``<name>.parquet`` of a result folder; an absent file is an empty table.

    Parameters
    ----------
    folder : Path
    name : str
        File name without suffix.
    columns : sequence of str, optional
        Read these columns only (at least two; those that exist); by default all.
    """
    path = folder / f"{name}.csv"
    if path.exists():
        with path.open(encoding="utf-8", newline="") as stream:
            return _read_csv(stream, columns)
    path = folder / f"{name}.parquet"
    if not path.exists():
        return ReadTable({})
    _, parquet = imported_pyarrow()
    names = parquet.read_schema(path).names
    table = parquet.read_table(path, columns=[n for n in names if columns is None or n in columns])
    return ReadTable(
        {
            key: ["" if x is None else str(x) for x in table.column(key).to_pylist()]
            for key in table.column_names
        }
    )


def _read_csv(stream: TextIO, columns: Sequence[str] | None) -> ReadTable:
    reader = csv.reader(stream)
    header = next(reader, [])
    wanted = [name for name in header if columns is None or name in columns]
    pick = itemgetter(*(header.index(name) for name in wanted)) if len(wanted) > 1 else tuple
    read = [list(column) for column in zip(*map(pick, reader), strict=True)]
    return ReadTable(dict(zip(wanted, read or [[] for _ in wanted], strict=True)))
