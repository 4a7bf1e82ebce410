"""A table by its columns: numbers, standard deviations, whole numbers, identifiers, and what is wrong with them.

Numbers are checked as whole columns; only where that fails, single rows are looked at, and the first bad ones
are reported with file, line and column.  Identifiers stay texts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.project.diagnostics import SHOWN_PER_KIND, Collector, Place
from splinebba_cli.project.labels import Labels
from splinebba_cli.project.plain_text import id_problem
from splinebba_cli.project.scalars import LARGEST_NUMBER, SIGMA_RANGE, parse_number, parse_sigma

_BLANKS = {"", "-", "na", "NA"}
_YES, _NO = {"yes", "true", "1", "", "-"}, {"no", "false", "0"}


@dataclass
class Table:
    """Columns of texts or of numbers (arrays; a blank is NaN), and where every row stands."""

    file: str
    columns: Mapping[str, Sequence[Any]]
    rows: int
    place_of: Callable[[int, str], Place]  # row, column -> place
    collector: Collector
    head: Place
    _read: dict[tuple[str, str], FloatArray] = field(default_factory=dict)  # read (and reported) once
    _labels: dict[str, Labels] = field(default_factory=dict)

    def has(self, name: str) -> bool:
        """Whether the table has a column."""
        return name in self.columns

    def texts(self, name: str) -> list[str]:
        """A column of identifiers; an empty one is an error."""
        return list(self.labels(name))

    def labels(self, name: str) -> Labels:
        """A column of identifiers, each different one once; an empty one is an error (once for each row)."""
        if name not in self._labels:
            self._labels[name] = self.words(name)
            for number, text in enumerate(self._labels[name].names):
                if not text:
                    rows = np.flatnonzero(self._labels[name].number == number)
                    self._report(rows, name, lambda row: f"no `{name}`")
                elif problem := id_problem(text):
                    rows = np.flatnonzero(self._labels[name].number == number)[:1]
                    self._report(rows, name, partial("`{}` {}".format, name, problem), "SBB210")
        return self._labels[name]

    def words(self, name: str) -> Labels:
        """A column of texts without blanks around them, each different one once."""
        return _stripped(self.columns[name])

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
            values = np.asarray(raw, dtype=np.float64)
            if not (np.abs(values) <= LARGEST_NUMBER).all():
                bad = np.flatnonzero(~(np.abs(values) <= LARGEST_NUMBER) & ~(np.isnan(values) & optional))
                self._report(bad, name, lambda row: _what_is_wrong(name, float(values[row])))
            return values
        if isinstance(raw, Labels):
            return self._by_name(name, parse_number, blank=math.nan if optional else None)
        try:
            values = np.array(list(map(float, raw)), dtype=np.float64)
            if (np.abs(values) <= LARGEST_NUMBER).all() and not any(map("_".__eq__, set("".join(raw)))):
                return values
        except (ValueError, TypeError):
            pass
        return self._one_by_one(name, parse_number, blank=math.nan if optional else None)

    def _sigmas(self, name: str) -> FloatArray:
        raw = self.columns[name]
        if isinstance(raw, np.ndarray):
            values = np.asarray(raw, dtype=np.float64)
            binary = self.place_of(0, name).line is None  # in which 0 is fixed, there being no words
            bad = np.flatnonzero((values < 0.0) if binary else (values <= 0.0))
            help = "" if binary else "; write `fixed` for a value that is not estimated"
            self._report(bad, name, lambda row: f"sigma {values[row]:g} is not positive{help}", "SBB309")
            least, largest = SIGMA_RANGE
            far = (values > 0.0) & np.isfinite(values) & ((values < least) | (values > largest))
            message = f"is not between {least:g} and {largest:g}"
            self._report(np.flatnonzero(far), name, lambda row: f"sigma {values[row]:g} {message}")
            return values
        if isinstance(raw, Labels):
            return self._by_name(name, parse_sigma, blank=math.nan)
        try:
            values = np.array(list(map(float, raw)), dtype=np.float64)
            if ((values >= SIGMA_RANGE[0]) & (values <= SIGMA_RANGE[1])).all():
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
        words = self.words("use")
        names = [word.lower() for word in words.names]
        wrong = np.array([word not in _YES and word not in _NO for word in names], dtype=bool)
        bad = np.flatnonzero(wrong[words.number])
        self._report(bad, "use", lambda row: f"`use` is yes or no, not `{words[row].lower()}`")
        return np.array([word in _NO for word in names], dtype=bool)[words.number]

    def _by_name(self, name: str, parse: Callable[[Any], float], blank: float | None) -> FloatArray:
        """Numbers of a column of labels; row by row where one is bad."""
        words = self.words(name)
        try:
            known = [blank if blank is not None and w in _BLANKS else parse(w) for w in words.names]
        except ValueError:
            return self._one_by_one(name, parse, blank)
        return np.array(known, dtype=np.float64)[words.number]

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


def _what_is_wrong(name: str, value: float) -> str:
    if math.isnan(value):
        return f"no `{name}`"
    return f"`{name}` is not a finite number" if math.isinf(value) else f"`{name}`: {value:g} is too large"


def _stripped(values: Sequence[Any]) -> Labels:
    """Texts without blanks around them, each different one once, in the order of their first occurrence."""
    if isinstance(values, Labels):
        names = [name.strip() for name in values.names]
        if len(set(names)) == len(names):
            return Labels(names, values.number)
        number = _numbered(names)
        return Labels(
            tuple(number), np.array([number[name] for name in names], dtype=np.int64)[values.number]
        )
    texts = list(map(str.strip, map(str, values)))
    number = _numbered(texts)
    index = np.fromiter(map(number.__getitem__, texts), dtype=np.int64, count=len(texts))
    return Labels(tuple(number), index)


def _numbered(texts: Iterable[str]) -> dict[str, int]:
    return {text: number for number, text in enumerate(dict.fromkeys(texts))}
