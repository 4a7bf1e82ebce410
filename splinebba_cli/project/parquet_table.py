"""Side tables in Parquet: their columns as numbers or texts, after a look at what they hold and how much."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from splinebba_cli.project.diagnostics import Collector, Place
from splinebba_cli.project.file_content import TooLargeError, check_size
from splinebba_cli.project.regular_table import arrow_labels
from splinebba_cli.project.table import Table
from splinebba_cli.project.tables import TableUnreadableError

_BYTES_OF_A_VALUE = 8  # as it is read; a column that repeats one value takes none in the file
_NUMBERS = ("double", "float", "halffloat")
_WORDS = ("int", "uint", "string", "large_string", "dictionary", "bool", "null", "decimal")


def table_from_parquet(content: bytes, *, file: str, collector: Collector, declared_at: Place) -> Table:
    """The table of the bytes of a Parquet file; needs pyarrow."""
    try:
        from pyarrow import parquet  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        help = "install `splinebba[parquet]`, or write the table as CSV"
        collector.error("SBB406", "Parquet needs pyarrow, which is not installed", declared_at, help)
        raise TableUnreadableError from None
    try:
        opened = parquet.ParquetFile(io.BytesIO(content))
        _check_size(opened.metadata)
        read = opened.read()
    except TooLargeError as reason:
        collector.error("SBB409", f"table `{file}` is too large: {reason}", declared_at, "split the block")
        raise TableUnreadableError from None
    except Exception as error:  # noqa: BLE001 — pyarrow raises its own kinds
        reason_words = str(error).splitlines()[0] if str(error) else type(error).__name__
        collector.error("SBB401", f"`{file}` is no complete Parquet file: {reason_words}", declared_at)
        raise TableUnreadableError from None
    columns = _columns(read, file, collector, declared_at)
    if read.num_rows == 0:
        collector.error("SBB405", "the table has no rows", declared_at)
        raise TableUnreadableError

    def place_of(row: int, name: str) -> Place:
        return Place(file)

    return Table(file, columns, read.num_rows, place_of, collector, declared_at)


def _check_size(metadata: Any) -> None:
    stored = sum(metadata.row_group(k).total_byte_size for k in range(metadata.num_row_groups))
    check_size(max(stored, metadata.num_rows * metadata.num_columns * _BYTES_OF_A_VALUE))


def _columns(read: Any, file: str, collector: Collector, declared_at: Place) -> dict[str, Sequence[Any]]:
    columns: dict[str, Sequence[Any]] = {}
    for number, name in enumerate(read.column_names):
        column, kind = read.column(number), str(read.column(number).type)
        if read.column_names.index(name) < number:
            collector.error("SBB402", f"two columns of `{file}` are named `{name}`", declared_at)
            raise TableUnreadableError
        if kind.startswith(_NUMBERS):
            columns[name] = column.to_numpy()
        elif kind.startswith(_WORDS):
            encoded = column if kind.startswith("dictionary") else column.dictionary_encode()
            columns[name] = arrow_labels(encoded)
        else:
            help = "columns are numbers (double, int) or texts (string)"
            message = f"column `{name}` of `{file}` is left out: it is of type {kind}"
            collector.warning("SBB412", message, declared_at, help)
    return columns
