"""One kind of diagnostic for everything that may be wrong in a project, and its renderers."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Literal, overload

from splinebba_cli.errors import ERROR_CODES
from splinebba_cli.project.plain_text import brief, same_letters, shown

Severity = Literal["error", "warning", "info"]

#: How consoles set off a severity, in the words of rich.
SEVERITY_STYLES: dict[str, str] = {"error": "bold red", "warning": "bold yellow", "info": "bold cyan"}
#: So many diagnostics of one kind and table are spelt out; the rest is counted.
SHOWN_PER_KIND = 20
LONGEST_MESSAGE = 600


@dataclass(frozen=True)
class Place:
    """Where something stands: lines and columns count from 1; a row of a binary table has no line."""

    file: str
    line: int | None = None
    column: int | None = None
    length: int = 1
    snippet: str = ""  # the text of the line


class Places(Sequence[Place]):
    """Where many things stand, each found when it is asked for."""

    def __init__(self) -> None:
        self._find: list[Callable[[], Place]] = []

    def append(self, find: Callable[[], Place]) -> None:
        """Add a place by the function that finds it."""
        self._find.append(find)

    @overload
    def __getitem__(self, number: int) -> Place: ...
    @overload
    def __getitem__(self, number: slice) -> list[Place]: ...
    def __getitem__(self, number: int | slice) -> Place | list[Place]:
        if isinstance(number, slice):
            return [find() for find in self._find[number]]
        return self._find[number]()

    def __len__(self) -> int:
        return len(self._find)


@dataclass(frozen=True)
class Diagnostic:
    """What is wrong, where, and what would cure it."""

    code: str
    severity: Severity
    message: str
    help: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None
    length: int = 1
    snippet: str = ""

    @property
    def position(self) -> str:
        """``file:line:column`` as far as it is known."""
        parts = [self.file, self.line, self.column]
        return ":".join(str(part) for part in parts if part is not None and part != "")


class Collector:
    """Gathers diagnostics, so that all errors are reported in one go."""

    def __init__(self) -> None:
        self.items: list[Diagnostic] = []
        self._counts: dict[tuple[str, str, str], int] = {}

    def add(
        self,
        severity: Severity,
        code: str,
        message: str,
        place: Place,
        help: str = "",
        *,
        kind: str | None = None,
    ) -> None:
        """Add one; of each `kind` in one file only the first ones are kept, the others counted."""
        if kind is not None:
            key = (code, place.file, kind)
            self._counts[key] = self._counts.get(key, 0) + 1
            if self._counts[key] > SHOWN_PER_KIND:
                return
        assert code in ERROR_CODES, code
        self.items.append(
            Diagnostic(
                code,
                severity,
                shown(brief(message, LONGEST_MESSAGE)),
                shown(help),
                shown(place.file),
                place.line,
                place.column,
                place.length,
                shown(place.snippet.replace("\t", " ")),
            )
        )

    def error(
        self, code: str, message: str, place: Place, help: str = "", *, kind: str | None = None
    ) -> None:
        """Add an error; see :meth:`add`."""
        self.add("error", code, message, place, help, kind=kind)

    def warning(
        self, code: str, message: str, place: Place, help: str = "", *, kind: str | None = None
    ) -> None:
        """Add a warning; see :meth:`add`."""
        self.add("warning", code, message, place, help, kind=kind)

    def count_more(self, code: str, file: str, kind: str, number: int) -> None:
        """Count diagnostics of a kind that are not spelt out."""
        self._counts[(code, file, kind)] = self._counts.get((code, file, kind), 0) + number

    def take(self, other: Collector, codes: tuple[str, ...]) -> None:
        """Take over those diagnostics of another collector whose codes begin with one of `codes`, at new places."""
        known = {item.position for item in self.items if item.line is not None}
        self.items += [i for i in other.items if i.code.startswith(codes) and i.position not in known]
        for (code, file, kind), count in other._counts.items():
            if code.startswith(codes):
                self._counts[(code, file, kind)] = self._counts.get((code, file, kind), 0) + count

    @property
    def has_errors(self) -> bool:
        """Whether any of the diagnostics is an error."""
        return any(item.severity == "error" for item in self.items)

    def finished(self) -> tuple[Diagnostic, ...]:
        """All diagnostics in the order of the files, with the number of those left out."""
        more = {key: count - SHOWN_PER_KIND for key, count in self._counts.items() if count > SHOWN_PER_KIND}
        items = list(self.items)
        for (code, file, kind), count in more.items():
            last = max(i for i, item in enumerate(items) if item.code == code and item.file == file)
            note = f"… and {count} more: {kind}"
            items.insert(last + 1, replace(items[last], message=note, help="", snippet=""))
        files = list(dict.fromkeys(item.file for item in items))
        items.sort(key=lambda item: (files.index(item.file), item.line or 0))
        return tuple(items)


def suggestion(word: str, known: Iterable[str]) -> str:
    """A help line ``did you mean `x`?`` where a known word is near, else empty."""
    from difflib import get_close_matches

    known = [one for one in known if one != word]
    alike = next((one for one in known if same_letters(one, word)), None)
    if alike is not None:
        return f"`{alike}` looks the same but is written with other characters (Unicode forms of accents or blanks)"
    near = get_close_matches(word, known, n=1, cutoff=0.6)
    return f"did you mean `{near[0]}`?" if near else ""


def listing(words: Iterable[str], limit: int = 8) -> str:
    """Some words as ```a`, `b`, …``."""
    all_words = list(words)
    shown = ", ".join(f"`{word}`" for word in all_words[:limit])
    return shown + (f", … ({len(all_words)} in all)" if len(all_words) > limit else "")


def render_text(diagnostics: Iterable[Diagnostic]) -> str:
    """Message, position, the line itself, a caret and a help line for each."""
    return "\n\n".join(_one_text(item) for item in diagnostics)


def _one_text(item: Diagnostic) -> str:
    from rich.cells import cell_len

    lines = [f"{item.severity}[{item.code}]: {item.message}"]
    gutter = " " * len(str(item.line or ""))
    if item.file:
        lines.append(f"{gutter}--> {item.position}")
    if item.snippet and item.line is not None:
        snippet, column, length = _window(item.snippet, item.column or 1, item.length)
        before, marked = snippet[: column - 1], snippet[column - 1 : column - 1 + length]
        lines.append(f"{gutter} |")
        lines.append(f"{item.line} | {snippet}".rstrip())
        lines.append(f"{gutter} | {' ' * cell_len(before)}{'^' * max(1, cell_len(marked))}")
    if item.help:
        lines.append(f"{gutter} = help: {item.help}")
    return "\n".join(lines)


def _window(text: str, column: int, length: int, width: int = 100) -> tuple[str, int, int]:
    """The part of a long line around the caret; the caret never leaves the line by more than one."""
    length = max(1, min(length, len(text) - column + 1))
    if len(text) <= width:
        return text, column, length
    start = max(0, column - 1 - width // 2)
    part = text[start : start + width]
    lead = "…" if start else ""
    tail = "…" if start + width < len(text) else ""
    return lead + part + tail, column - start + len(lead), min(length, width)


def as_json_data(diagnostics: Iterable[Diagnostic]) -> list[dict[str, object]]:
    """Plain data of diagnostics: code, severity, message, help, file, line, column, length."""
    return [{key: value for key, value in asdict(item).items() if key != "snippet"} for item in diagnostics]


def render_json(diagnostics: Iterable[Diagnostic]) -> str:
    """A JSON array."""
    return json.dumps(as_json_data(diagnostics), indent=2, ensure_ascii=False)


def render_github(diagnostics: Iterable[Diagnostic]) -> str:
    """Workflow commands that annotate the lines of a pull request."""
    return "\n".join(_one_github(item) for item in diagnostics)


def _one_github(item: Diagnostic) -> str:
    level = {"error": "error", "warning": "warning", "info": "notice"}[item.severity]
    properties = [f"file={_escape(item.file, True)}"] if item.file else []
    if item.line is not None:
        properties.append(f"line={item.line}")
    if item.line is not None and item.column is not None:
        properties += [f"col={item.column}", f"endColumn={item.column + item.length}"]
    properties.append(f"title={item.code}")
    message = item.message + (f"\nhelp: {item.help}" if item.help else "")
    return f"::{level} {','.join(properties)}::{_escape(message)}"


def _escape(text: str, is_property: bool = False) -> str:
    text = text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    return text.replace(":", "%3A").replace(",", "%2C") if is_property else text
