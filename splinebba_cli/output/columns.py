"""Plain tables of columns: written as CSV or Parquet, read back the same way.

A column is text or numbers; NaN is an empty field.  The unit is part of a column's name (``residual_x_mm``).
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import compress
from operator import itemgetter
from pathlib import Path
from typing import Any, Literal, TextIO

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.errors import OutputError
from splinebba_cli.output.labels import Labels
from splinebba_cli.output.number_text import Words, fixed_words, integer_words, lines, text_words
from splinebba_cli.output.significant_text import significant_words

TableFormat = Literal["csv", "parquet"]
_ROWS_AT_ONCE = 20_000
_FORM = re.compile(r"%\.(\d+)([fg])")
_WORDS = {"f": fixed_words, "g": significant_words}
_NEEDS_QUOTES = re.compile(r'[,"\r\n]|^\s|\s$')


@dataclass(frozen=True)
class Column:
    """One column: a name with its unit, the values, and how a number is printed.

    ``decimals`` is a printf format such as ``%.7f``; None prints the shortest text that reads back the same.
    """

    name: str
    values: NDArray[np.float64] | NDArray[np.int64] | Sequence[str]
    decimals: str | None = None


@dataclass(frozen=True)
class Table:
    """A table as it is written; all columns have the same length."""

    name: str  # file name without suffix
    columns: tuple[Column, ...]

    def __len__(self) -> int:
        return len(self.columns[0].values) if self.columns else 0


def write_table(folder: Path, table: Table, fmt: TableFormat) -> Path:
    """Write ``<folder>/<name>.csv`` or ``.parquet``.

    Raises
    ------
    OutputError
        SBB406 if Parquet is asked for and pyarrow is not installed.
    """
    path = folder / f"{table.name}.{fmt}"
    if fmt == "parquet":
        _write_parquet(path, table)
    else:
        names = [_label_words(column) for column in table.columns]
        with path.open("wb") as stream:
            stream.write((",".join(column.name for column in table.columns) + "\n").encode())
            for first in range(0, len(table), _ROWS_AT_ONCE):
                rows = slice(first, first + _ROWS_AT_ONCE)
                cells = [_cells(column, rows, words) for column, words in zip(table.columns, names, strict=True)]
                stream.write(lines(cells, b","))
    return path


def _label_words(column: Column) -> Words | None:
    """The quoted names of a column of labels."""
    if not isinstance(column.values, Labels):
        return None
    return text_words([_quoted(name) for name in column.values.names] or [""])


def _cells(column: Column, rows: slice, names: Words | None) -> Words:
    """The text of some rows of a column; infinite and missing numbers are blank, -0.0 is 0.0."""
    values = column.values[rows]
    if names is not None and isinstance(values, Labels):
        return names[values.index]
    if not isinstance(values, np.ndarray):
        return text_words([_quoted(text) for text in values])
    if values.dtype.kind in "iu":
        return integer_words(values.astype(np.int64))
    numbers = values + 0.0
    form = _FORM.fullmatch(column.decimals or "")
    words = None
    if form is not None:
        words = _WORDS[form[2]](numbers, int(form[1]))
    return text_words(_printed(numbers, column.decimals)) if words is None else words


def _printed(values: NDArray[np.float64], decimals: str | None) -> list[str]:
    numbers = values.tolist()
    if decimals is None:
        return [repr(x) if math.isfinite(x) else "" for x in numbers]
    texts = "\n".join([decimals] * len(numbers)) % tuple(numbers)
    return texts.replace("-inf", "").replace("inf", "").replace("nan", "").split("\n")


def _quoted(text: str) -> str:
    if _NEEDS_QUOTES.search(text):
        return '"' + text.replace('"', '""') + '"'
    return text


def _write_parquet(path: Path, table: Table) -> None:
    pyarrow, parquet = _pyarrow()
    arrays, names = [], []
    for column in table.columns:
        values = column.values
        if isinstance(values, Labels):
            index = pyarrow.array(values.index, type=pyarrow.int32())
            arrays.append(pyarrow.DictionaryArray.from_arrays(index, pyarrow.array(list(values.names))))
        elif isinstance(values, np.ndarray) and values.dtype.kind == "f":
            arrays.append(pyarrow.array(values, from_pandas=True))  # NaN becomes null
        else:
            arrays.append(
                pyarrow.array(values, type=None if isinstance(values, np.ndarray) else pyarrow.string())
            )
        names.append(column.name)
    parquet.write_table(pyarrow.table(arrays, names=names), path, compression="zstd")


def _pyarrow() -> tuple[Any, Any]:
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError as error:
        raise OutputError(
            "SBB406",
            "Parquet tables need pyarrow",
            "pip install 'splinebba[parquet]', or use --tables csv",
        ) from error


class ReadTable(Mapping[str, list[str]]):
    """A table read back: columns of text, or of numbers by :meth:`numbers`."""

    def __init__(self, columns: dict[str, list[str]]) -> None:
        self._columns = columns

    def __getitem__(self, name: str) -> list[str]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self._columns.values()), []))

    def where(self, name: str, keep: Callable[[str], bool]) -> ReadTable:
        """The rows whose field of a column is wanted; all where the table has no such column."""
        if name not in self._columns or all(map(keep, set(self._columns[name]))):
            return self
        wanted = [keep(field) for field in self._columns[name]]
        return ReadTable({key: list(compress(column, wanted)) for key, column in self._columns.items()})

    def numbers(self, name: str) -> NDArray[np.float64]:
        """A column as floats, NaN where empty; all NaN where the table has no such column."""
        if name not in self._columns:
            return np.full(self.rows, np.nan)
        return np.array([text or "nan" for text in self._columns[name]], dtype=np.float64)


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
    _, parquet = _pyarrow()
    table = parquet.read_table(path, columns=None if columns is None else list(columns))
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
