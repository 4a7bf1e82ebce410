"""What a report is made of: sections of blocks, as plain data; the renderers know how to lay them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, overload

Tone = Literal["good", "warning", "bad", "neutral"]
Cell = str | float | int | None


class LazyRows(Sequence[tuple[Cell, ...]]):
    """Rows of a long table, made when they are shown: few of them are.

    Parameters
    ----------
    count : number of rows
    row : makes one
    """

    def __init__(self, count: int, row: Callable[[int], tuple[Cell, ...]]) -> None:
        self._count = count
        self._row = row

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, number: int) -> tuple[Cell, ...]: ...
    @overload
    def __getitem__(self, number: slice) -> tuple[tuple[Cell, ...], ...]: ...
    def __getitem__(self, number: int | slice) -> tuple[Cell, ...] | tuple[tuple[Cell, ...], ...]:
        if isinstance(number, slice):
            return tuple(map(self._row, range(*number.indices(self._count))))
        if not -self._count <= number < self._count:
            raise IndexError(f"row {number} of {self._count}")
        return self._row(number % self._count)


@dataclass(frozen=True)
class Verdict:
    """The one sentence that people open the report for."""

    tone: Tone
    headline: str
    detail: str


@dataclass(frozen=True)
class Fact:
    """A labelled value; `value` is text, ready to be shown, with its unit.

    `number` and `unit` are the same for programs: all digits, in a base unit (m, °, px).
    """

    label: str
    value: str
    note: str = ""
    tone: Tone = "neutral"
    number: float | int | None = None
    unit: str = ""


@dataclass(frozen=True)
class Facts:
    """A list of labelled values; `headline` ones are shown large."""

    items: tuple[Fact, ...]
    headline: bool = False


@dataclass(frozen=True)
class Column:
    """A column of a table.

    `decimals` None is text or a whole number; otherwise numbers are shown with so many decimals.
    """

    title: str
    unit: str = ""
    decimals: int | None = None
    numeric: bool = True
    help: str = ""

    @property
    def heading(self) -> str:
        """Title with unit: ``X [m]``."""
        return f"{self.title} [{self.unit}]" if self.unit else self.title


@dataclass(frozen=True)
class Table:
    """Rows of cells; `marked` rows deserve a look; `source` is the file that has all rows."""

    caption: str
    columns: tuple[Column, ...]
    rows: Sequence[tuple[Cell, ...]]
    marked: frozenset[int] = frozenset()
    source: str = ""
    folded: bool = False  # shown closed where the medium can
    note: str = ""

    @property
    def legend(self) -> tuple[Column, ...]:
        """The columns whose heading needs a word."""
        return tuple(column for column in self.columns if column.help)


@dataclass(frozen=True)
class Note:
    """A paragraph."""

    text: str


@dataclass(frozen=True)
class ProblemItem:
    """A problem with what would cure it."""

    code: str
    severity: Literal["error", "warning", "info"]
    subject: str
    message: str
    help: str

    @property
    def about(self) -> str:
        """The subject, unless the message names it already."""
        return "" if self.subject in self.message else self.subject

    @property
    def sentence(self) -> str:
        """Subject and message."""
        return f"{self.about}: {self.message}" if self.about else self.message


@dataclass(frozen=True)
class ProblemList:
    """Problems, the worst first; empty: none were found."""

    items: tuple[ProblemItem, ...]


@dataclass(frozen=True)
class FigureBlock:
    """A figure by its name in :mod:`splinebba_cli.report.figures`; `subject` is the id of a spline or a camera."""

    figure: str
    caption: str
    alt: str
    subject: str = ""


Block = Facts | Table | Note | ProblemList | FigureBlock


@dataclass(frozen=True)
class Section:
    """A titled part of the report; `id` is stable, for links."""

    id: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Report:
    """Everything that is said, in the order of saying."""

    title: str
    subtitle: str
    verdict: Verdict
    key_facts: Facts
    sections: tuple[Section, ...]
    kicker: str = "Bundle block adjustment"  # what kind of report it is


def cell_text(column: Column, cell: Cell) -> str:
    """A cell as text: fixed decimals, a plain minus so that numbers can be copied, a dash for no value."""
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    if column.decimals is None:
        return f"{cell:d}" if isinstance(cell, int) else f"{cell:g}"
    text = f"{cell:.{column.decimals}f}"
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text
