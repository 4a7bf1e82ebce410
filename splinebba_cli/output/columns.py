"""Plain tables of columns, written as CSV or Parquet.

A column is text or numbers; NaN is an empty field.  The unit is part of a column's name (``residual_x_mm``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.errors import OutputError
from splinebba_cli.output.number_text import Words, fixed_words, integer_words, lines, text_words
from splinebba_cli.output.significant_text import significant_words
from splinebba_cli.project.labels import Labels
from splinebba_cli.project.shortest_text import shortest_texts

TableFormat = Literal["csv", "parquet"]
_ROWS_AT_ONCE = 4_000
FORM = re.compile(r"%\.(\d+)([fg])")
_WORDS = {"f": fixed_words, "g": significant_words}
_NEEDS_QUOTES = re.compile(r'[,"\r\n]|^[\s#]|\s$')


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
                cells = [
                    _cells(column, rows, words) for column, words in zip(table.columns, names, strict=True)
                ]
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
        return names[values.number]
    if not isinstance(values, np.ndarray):
        quoted = {text: _quoted(text) for text in set(values)}
        return text_words(list(map(quoted.__getitem__, values)))
    if values.dtype.kind in "iu":
        return integer_words(values.astype(np.int64))
    numbers = np.asarray(values + 0.0, dtype=np.float64)
    if (numbers == numbers[0]).all() or np.isnan(numbers).all():
        return np.repeat(text_words(printed(numbers[:1], column.decimals)), len(numbers), axis=0)
    form = FORM.fullmatch(column.decimals or "")
    words = None
    if form is not None:
        words = _WORDS[form[2]](numbers, int(form[1]))
    return text_words(printed(numbers, column.decimals)) if words is None else words


def printed(values: NDArray[np.float64], decimals: str | None) -> list[str]:
    """Numbers as they are written, (n,); infinite and missing ones are empty."""
    if decimals is None:
        finite = np.isfinite(values)
        texts = shortest_texts(np.asarray(values, dtype=np.float64))
        return texts if finite.all() else [text if x else "" for text, x in zip(texts, finite, strict=True)]
    numbers = values.tolist()
    joined = "\n".join([decimals] * len(numbers)) % tuple(numbers)
    return joined.replace("-inf", "").replace("inf", "").replace("nan", "").split("\n")


def _quoted(text: str) -> str:
    if _NEEDS_QUOTES.search(text):
        return '"' + text.replace('"', '""') + '"'
    return text


def _write_parquet(path: Path, table: Table) -> None:
    pyarrow, parquet = imported_pyarrow()
    arrays, names = [], []
    for column in table.columns:
        values = column.values
        if isinstance(values, Labels):
            index = pyarrow.array(values.number, type=pyarrow.int32())
            arrays.append(pyarrow.DictionaryArray.from_arrays(index, pyarrow.array(list(values.names))))
        elif isinstance(values, np.ndarray) and values.dtype.kind == "f":
            arrays.append(pyarrow.array(values, from_pandas=True))  # NaN becomes null
        else:
            arrays.append(
                pyarrow.array(values, type=None if isinstance(values, np.ndarray) else pyarrow.string())
            )
        names.append(column.name)
    parquet.write_table(pyarrow.table(arrays, names=names), path, compression="zstd")


def imported_pyarrow() -> tuple[Any, Any]:
    """The packages pyarrow and pyarrow.parquet; OutputError SBB406 where they are not installed."""
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError as error:
        raise OutputError(
            "SBB406",
            "Parquet tables need pyarrow",
            "pip install 'splinebba[parquet]', or use --tables csv",
        ) from error
