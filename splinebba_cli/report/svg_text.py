"""Markup of drawings: numbers, escaped texts, and what an element says when it is pointed at."""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

_DRAWN = re.compile(r"<(use|path)\b([^>]*?)/>")
_SHARED = re.compile(r' (?:clip-path|style)="[^"]*"')
_DEFINITIONS = re.compile(r"<defs>.*?</defs>", re.DOTALL)


def visible(text: str, longest: int | None = None) -> str:
    """An id of the user in one line: control characters made visible, cut after `longest` characters."""
    shown = text
    if not text.isprintable():
        shown = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
    return shown if longest is None or len(shown) <= longest else f"{shown[: longest - 1]}…"


def plain(text: str) -> str:
    """Lines of text, escaped for elements and attributes, control characters made visible."""
    return escape("\n".join(map(visible, text.split("\n"))), quote=True)


def one_line(text: str, longest: int | None = None) -> str:
    """An id, escaped, without line breaks, cut after `longest` characters."""
    return escape(visible(text, longest), quote=True)


def number(value: float, decimals: int = 2) -> str:
    """A coordinate as short as it may be: ``12.5``, ``-0.25``, ``3``."""
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text in ("-0", "") else text


def titled(tag: str, attributes: str, tip: str) -> str:
    """An element that says `tip` (plain text, lines end with a line feed)."""
    return f"<{tag} {attributes.strip()}><title>{plain(tip)}</title></{tag}>"


class Tips:
    """What the elements of a drawing say when they are pointed at.

    Artists of matplotlib get a group id; the texts are put into the SVG as ``<title>`` of the elements of the group.
    """

    def __init__(self) -> None:
        self._texts: dict[str, Sequence[str]] = {}

    def on(self, artist: object, texts: Sequence[str]) -> None:
        """One text for every marker, line or area of `artist`; a single text belongs to all of it."""
        key = f"tips-{len(self._texts)}-"
        artist.set_gid(key)  # type: ignore[attr-defined]
        self._texts[key] = texts

    def into(self, svg: str) -> str:
        """The SVG with its titles; groups whose elements were left out of the drawing keep none."""
        for key, texts in self._texts.items():
            start = svg.find(f'<g id="{key}"')
            if start >= 0:
                end = _end_of_group(svg, start)
                svg = svg[:start] + _with_titles(svg[start:end], texts) + svg[end:]
        return svg


def _end_of_group(svg: str, start: int) -> int:
    depth = 0
    for match in re.finditer(r"<g\b[^>]*?(/?)>|</g>", svg[start:]):
        if match.group(0) == "</g>":
            depth -= 1
        elif not match.group(1):
            depth += 1
        if depth == 0:
            return start + match.end()
    return len(svg)


def _with_titles(group: str, texts: Sequence[str]) -> str:
    if len(texts) == 1:
        head, rest = group.split(">", 1)
        return f"{head}><title>{plain(texts[0])}</title>{rest}"
    hidden = [match.span() for match in _DEFINITIONS.finditer(group)]
    drawn = [m for m in _DRAWN.finditer(group) if not any(a <= m.start() < b for a, b in hidden)]
    if not drawn or len(drawn) != len(texts):
        return group
    shared = [each for each in _SHARED.findall(drawn[0].group(2)) if all(each in m.group(2) for m in drawn)]
    parts, place = [], group.index(">")
    head = group[:place] + "".join(shared)
    for match, text in zip(drawn, texts, strict=True):
        attributes = _SHARED.sub(lambda m: "" if m.group(0) in shared else m.group(0), match.group(2))
        parts += [group[place : match.start()], titled(match.group(1), attributes, text)]
        place = match.end()
    return head + "".join(parts) + group[place:]
