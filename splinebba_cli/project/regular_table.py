"""CSV tables without quotes, comments and empty lines, read by compiled readers: pyarrow, else numpy.

What is not such a table, or holds a value that these readers do not take, is left to the reader of rows, which knows
every form and says what is wrong where.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.labels import Labels

Columns = Mapping[str, FloatArray | Labels]

_OTHER_LINE_ENDS = (b"\v", b"\f", b"\x1c", b"\x1d", b"\x1e")
_LONG_LINE_ENDS = (b"\xc2\x85", b"\xe2\x80\xa8", b"\xe2\x80\xa9")  # in UTF-8
_NOT_REGULAR = (b'"', b"#", b"\0", *_OTHER_LINE_ENDS)
_BLANKS = ["", "-", "na", "NA"]
_FEWEST_BYTES = 200_000  # below which the reader of rows is as fast
_BLOCK = 1 << 24  # bytes that numpy looks at at once


@dataclass(frozen=True)
class Shape:
    """What the columns of a table are."""

    names: Sequence[str]
    texts: frozenset[str]  # columns of identifiers and words
    numbers: frozenset[str]  # columns of numbers; others are not read
    separator: str
    header: bool


def regular_columns(path: Path, content: bytes, shape: Shape) -> Columns | None:
    """The columns of a large regular table, in which a blank number is NaN; None where it is none.

    Parameters
    ----------
    path : Path
        The file.
    content : bytes
        Its content without a byte order mark.
    """
    if len(content) < _FEWEST_BYTES or any(mark in content for mark in _NOT_REGULAR):
        return None
    if b"\r" in content and content.count(b"\r") != content.count(b"\r\n"):
        return None
    if len(shape.names) == 1 and (b"\n\n" in content or b"\n\r" in content):
        return None  # else an empty line is one with too few fields
    if not content.isascii():
        if any(mark in content for mark in _LONG_LINE_ENDS):
            return None
        try:
            content.decode()
        except UnicodeDecodeError:
            return None
    try:
        import pyarrow.csv
    except ImportError:
        return _by_numpy(path, content, shape)
    return _by_arrow(pyarrow, content, shape)


def _by_arrow(pyarrow: Any, content: bytes, shape: Shape) -> Columns | None:
    """By pyarrow; a column of numbers that holds words becomes a column of texts."""
    texts = set(shape.texts)
    text_type, csv = pyarrow.dictionary(pyarrow.int32(), pyarrow.string()), pyarrow.csv
    lines = content.count(b"\n") + (not content.endswith(b"\n")) - shape.header
    names = [f"{number}" for number in range(len(shape.names))]
    wanted = [n for n, name in zip(names, shape.names, strict=True) if name in shape.texts | shape.numbers]
    for _ in shape.names:
        types = {n: text_type if shape.names[int(n)] in texts else pyarrow.float64() for n in wanted}
        try:
            table = csv.read_csv(
                pyarrow.BufferReader(content),
                csv.ReadOptions(column_names=names, skip_rows=int(shape.header)),
                csv.ParseOptions(delimiter=shape.separator, quote_char=False),
                csv.ConvertOptions(
                    column_types=types, include_columns=wanted, null_values=_BLANKS, strings_can_be_null=False
                ),
            )
        except pyarrow.ArrowInvalid as error:
            refused = re.search(r"CSV column #(\d+)", str(error))
            if refused is None or shape.names[int(refused[1])] in texts:
                return None
            texts.add(shape.names[int(refused[1])])
            continue
        if table.num_rows != lines:
            return None  # there are empty ones
        found = {shape.names[int(n)]: _arrow_column(pyarrow, table.column(n)) for n in wanted}
        words = {name for name, column in found.items() if column is None}
        if not words:
            return {name: column for name, column in found.items() if column is not None}
        texts |= words
    return None


def _arrow_column(pyarrow: Any, column: Any) -> FloatArray | Labels | None:
    """A column as an array; None where numbers are written as nan or inf."""
    if pyarrow.types.is_dictionary(column.type):
        return arrow_labels(column)
    values: FloatArray = column.to_numpy()
    return values if int((~np.isfinite(values)).sum()) == column.null_count else None


def arrow_labels(column: Any) -> Labels:
    """A dictionary-encoded column of pyarrow; null is empty."""
    whole = column.unify_dictionaries().combine_chunks()
    parts = whole.chunks if hasattr(whole, "chunks") else [whole]
    if not parts:
        return Labels((), np.empty(0, dtype=np.int64))
    names = [str(name) for name in parts[0].dictionary.to_pylist()]
    number = np.concatenate([part.indices.fill_null(len(names)).to_numpy() for part in parts])
    if column.null_count:
        names.append("")
    return Labels(names, number.astype(np.int64))


def _by_numpy(path: Path, content: bytes, shape: Shape) -> Columns | None:
    """By numpy's reader of numbers, and texts cut out of the bytes; None where a number is no number."""
    body = content[content.find(b"\n") + 1 :] if shape.header else content
    body = body.replace(b"\r\n", b"\n") if b"\r" in body else body
    body = body if body.endswith(b"\n") else body + b"\n"
    texts = [k for k, name in enumerate(shape.names) if name in shape.texts]
    numbers = [k for k, name in enumerate(shape.names) if name in shape.numbers]
    cut: dict[int, list[Labels]] = {k: [] for k in texts}
    for block in _blocks(body):
        ends = np.flatnonzero((block == ord(shape.separator)) | (block == ord("\n")))
        width = len(shape.names)
        if len(ends) % width or not _ends_lines(block, ends, width):
            return None
        starts = np.concatenate([[0], ends[:-1] + 1])
        for k in texts:
            cut[k].append(_cut(block, starts[k::width], ends[k::width]))
    columns: dict[str, FloatArray | Labels] = {shape.names[k]: _merged(parts) for k, parts in cut.items()}
    if numbers:
        try:
            values = np.loadtxt(
                path, delimiter=shape.separator, comments=None, usecols=numbers, ndmin=2,
                skiprows=int(shape.header), encoding="utf-8-sig",
            )  # fmt: skip
        except ValueError:
            return None
        if not np.isfinite(values).all():
            return None
        columns |= {shape.names[k]: values[:, i].copy() for i, k in enumerate(numbers)}
    return columns


def _blocks(body: bytes) -> Iterator[NDArray[np.uint8]]:
    """The bytes in parts that end with a line."""
    data, begin = np.frombuffer(body, dtype=np.uint8), 0
    while begin < len(body):
        end = len(body) if begin + _BLOCK >= len(body) else body.rfind(b"\n", begin, begin + _BLOCK) + 1
        if end <= begin:
            end = body.find(b"\n", begin) + 1
        yield data[begin:end]
        begin = end


def _ends_lines(block: NDArray[np.uint8], ends: IntArray, width: int) -> bool:
    """Whether every so manieth end of a field is the end of a line, and no other is."""
    last = block[ends].reshape(-1, width) == ord("\n")
    return bool(last[:, -1].all() and not last[:, :-1].any())


def _cut(block: NDArray[np.uint8], starts: IntArray, ends: IntArray) -> Labels:
    """The texts between starts and ends, each different one once."""
    length = ends - starts
    width = max(1, int(length.max()))
    place = starts[:, None] + np.arange(width)
    cells = np.where(np.arange(width) < length[:, None], block[np.minimum(place, len(block) - 1)], 0)
    texts = np.ascontiguousarray(cells, dtype=np.uint8).view(f"S{width}").ravel()
    first = np.flatnonzero(np.concatenate([[True], texts[1:] != texts[:-1]]))
    names, number = np.unique(texts[first], return_inverse=True)
    runs = np.diff(np.append(first, len(texts)))
    return Labels([name.decode() for name in names.tolist()], np.repeat(number, runs))


def _merged(parts: Sequence[Labels]) -> Labels:
    """Parts of a column under each other, each different text once."""
    joined = Labels.joined(*parts)
    names = {name: number for number, name in enumerate(dict.fromkeys(joined.names))}
    return Labels(tuple(names), np.array([names[name] for name in joined.names])[joined.number])


class LinesOfBytes(Sequence[str]):
    """The lines of a text, found when the first is asked for."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._ends: IntArray | None = None

    def _found(self) -> IntArray:
        if self._ends is None:
            self._ends = np.flatnonzero(np.frombuffer(self._content, dtype=np.uint8) == ord("\n"))
        return self._ends

    def __len__(self) -> int:
        return len(self._found()) + (not self._content.endswith(b"\n"))

    def __getitem__(self, line: Any) -> Any:
        ends = self._found()
        begin = int(ends[line - 1]) + 1 if line else 0
        end = int(ends[line]) if line < len(ends) else len(self._content)
        return self._content[begin:end].decode().rstrip("\r")


def first_line(content: bytes) -> str:
    """The first line of a text, for its names and its separator."""
    return io.BytesIO(content).readline().decode(errors="replace").rstrip("\r\n")
