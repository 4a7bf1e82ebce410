"""Texts of the user on a line of plain text."""

from __future__ import annotations


def one_line(text: str) -> str:
    """An id of the user with line ends, control characters and marks of direction made visible."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
