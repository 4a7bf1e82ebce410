"""Lines and columns of a text as editors count them, and where bytes are not UTF-8."""

from __future__ import annotations

import re
from collections.abc import Callable

from splinebba_cli.project.diagnostics import Place

_LINE_END = re.compile("\r\n|\r|\n")
UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def lines_of(text: str) -> list[str]:
    """Lines as editors count them: a form feed or U+2028 is part of a line."""
    lines = _LINE_END.split(text) if "\r" in text else text.split("\n")
    if lines and not lines[-1]:
        lines.pop()
    return lines


def decoded(content: bytes, file: str, refuse: Callable[[str, Place, str], None]) -> str | None:
    """The text of UTF-8, with or without a byte order mark; None, after a word to `refuse`, of anything else.

    Parameters
    ----------
    refuse : callable
        Gets message, place and help.
    """
    encoding = _other_encoding(content)
    if encoding:
        refuse(f"the file is {encoding}, not UTF-8", Place(file, 1, 1), "save it as UTF-8")
        return None
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        content = content.removeprefix(b"\xef\xbb\xbf")
        begin = content.rfind(b"\n", 0, error.start) + 1
        end = content.find(b"\n", error.start)
        column = len(content[begin : error.start].decode("utf-8", "replace"))
        line = content[begin : end if end >= 0 else None].decode("utf-8", "replace").rstrip("\r")
        number = content.count(b"\n", 0, error.start)
        place = Place(file, number + 1, column + 1, 1, line)
        message = f"byte 0x{content[error.start]:02x} is not UTF-8"
        meant = content[error.start : error.start + 1].decode("cp1252", "replace")
        looks = f" (here it would be `{meant}`)" if meant.isprintable() and meant != "�" else ""
        help = f"save the file as UTF-8; it may be Latin-1 or Windows-1252{looks}"
        refuse(message, place, "it is no text file" if b"\0" in content else help)
        return None


def _other_encoding(content: bytes) -> str:
    """UTF-16 and UTF-32 by their byte order marks, or by the zero bytes of a first ASCII character."""
    if content.startswith((b"\xff\xfe\0\0", b"\0\0\xfe\xff")):
        return "UTF-32"
    if content.startswith(UTF16_MARKS):
        return "UTF-16"
    head = content[:4]
    if len(head) == 4 and (head[0::2] == b"\0\0") != (head[1::2] == b"\0\0"):
        return "UTF-16"
    return ""
