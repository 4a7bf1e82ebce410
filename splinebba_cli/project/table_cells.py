"""Fields of one line of a table: separators, quotation marks, and where a field stands."""

from __future__ import annotations

import csv

_SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t"}
QUOTE = '"'


def separator_of(line: str, delimiter: str) -> str | None:
    """The character between fields, None for blanks."""
    if delimiter == "auto":
        return next((s for s in "\t;," if s in line), None)
    return _SEPARATORS.get(delimiter)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Fields of one line; an unclosed quotation makes it one field."""
    if separator is None:
        return line.split()
    if QUOTE not in line:
        return line.split(separator)
    if unclosed_quotation(line, separator) is not None:
        return [line]
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True))


def unclosed_quotation(line: str, separator: str | None) -> int | None:
    """Column (from 0) of a quotation mark that opens a field and has no end; None where there is none."""
    if separator is None or QUOTE not in line:
        return None
    for start, end in field_bounds(line, separator):
        lead = start + len(line[start:end]) - len(line[start:end].lstrip(" "))
        if line[lead : lead + 1] == QUOTE and not _closes(line[lead:end]):
            return lead
    return None


def _closes(field: str) -> bool:
    """Whether a field that begins with a quotation mark ends its quotation: doubled marks stand for one."""
    return field[1:].replace(QUOTE * 2, "").count(QUOTE) % 2 == 1


def field_bounds(line: str, separator: str) -> list[tuple[int, int]]:
    """Start and end of every field; separators between quotation marks do not count."""
    bounds, start, position = [], 0, 0
    while position <= len(line):
        if line[position : position + 1] == QUOTE and not line[start:position].strip(" "):
            position = _end_of_quotation(line, position + 1)
        end = line.find(separator, position)
        end = len(line) if end < 0 else end
        bounds.append((start, end))
        start = position = end + 1
    return bounds


def _end_of_quotation(line: str, position: int) -> int:
    """The place behind the closing mark, or the end of the line."""
    while True:
        position = line.find(QUOTE, position)
        if position < 0:
            return len(line)
        if line[position + 1 : position + 2] != QUOTE:
            return position + 1
        position += 2


def field_span(line: str, separator: str | None, index: int) -> tuple[int, int]:
    """Start and length of a field within its line, without blanks around it."""
    if separator is None:
        return _span_between_blanks(line, index)
    if QUOTE in line:
        bounds = field_bounds(line, separator)
        if index >= len(bounds):
            return len(line), 1
        start, end = bounds[index]
        cell = line[start:end]
    else:
        fields = line.split(separator)
        if index >= len(fields):
            return len(line), 1
        start, cell = sum(len(one) + 1 for one in fields[:index]), fields[index]
    lead = len(cell) - len(cell.lstrip()) if cell.strip() else 0
    return start + lead, max(1, len(cell.strip()))


def _span_between_blanks(line: str, index: int) -> tuple[int, int]:
    position = 0
    for _ in range(index + 1):
        while position < len(line) and line[position].isspace():
            position += 1
        start = position
        while position < len(line) and not line[position].isspace():
            position += 1
    return start, max(1, position - start)
