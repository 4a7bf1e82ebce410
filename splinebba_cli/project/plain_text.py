"""Which texts may be ids and names, and how any text is shown: nothing that a terminal or a spreadsheet would run.

Ids and names stand in every output: tables, JSON, XML, HTML, log files of a CI, the terminal.  What one of them would
take for a command is refused where it is read, so that no writer has to change an id, and what is written reads back
the same (OWASP, CSV Injection; CWE-150).
"""

from __future__ import annotations

import re
import unicodedata

_LINE_SEPARATORS = "\u2028\u2029"
_DIRECTION_MARKS = "\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
_INVISIBLE = "\ufeff\ufffe\uffff"
_NOT_PLAIN = re.compile(
    f"[\\x00-\\x1f\\x7f-\\x9f\\ud800-\\udfff{_LINE_SEPARATORS}{_DIRECTION_MARKS}{_INVISIBLE}]"
)
_NOT_PLAIN_LINES = re.compile(_NOT_PLAIN.pattern.replace("\\x00-\\x1f", "\\x00-\\x08\\x0b-\\x1f"))
_FORMULA = re.compile(r"[=@＝＠]|[-+－＋].*[^\w .:/+-]", re.DOTALL)
_COMMAND_OF_CI = "::"
LONGEST_ID = 200
_PICTURES = 0x2400  # control pictures: U+2400 shows U+0000


def id_problem(text: str) -> str:
    """Why a text cannot be an id or a name; empty where it can.

    Parameters
    ----------
    text : str
        Without blanks around it.
    """
    if not text.strip():
        return "must not be empty"
    found = _NOT_PLAIN.search(text)
    if found is not None:
        return f"must not hold {character_name(found[0])}"
    if text != text.strip():
        return "must not begin or end with a blank"
    if len(text) > LONGEST_ID:
        return f"must not have more than {LONGEST_ID} characters, not {len(text)}"
    if _FORMULA.match(text):
        return f"must not begin with `{text[0]}`: a spreadsheet program would run it as a formula"
    if text.startswith(_COMMAND_OF_CI):
        return f"must not begin with `{_COMMAND_OF_CI}`: the log of a CI service would take it for a command"
    return ""


def file_name_problem(text: str) -> str:
    """Why a text cannot name a table; empty where it can."""
    if not text.strip():
        return "a file name is expected"
    found = _NOT_PLAIN.search(text)
    if found is not None:
        return f"a file name must not hold {character_name(found[0])}"
    return id_problem(text) if _FORMULA.match(text) else ""


def text_problem(text: str) -> str:
    """Why a text of several lines cannot stand in a project; empty where it can."""
    found = _NOT_PLAIN_LINES.search(text)
    return "" if found is None else f"must not hold {character_name(found[0])}"


def character_name(character: str) -> str:
    """A character that cannot be shown, in words."""
    words = {
        "\n": "a line break", "\r": "a line break", "\t": "a tab", "\0": "a NUL character",
        "\x1b": "the control character ESC (U+001B)",
    }  # fmt: skip
    if character in words:
        return words[character]
    name = unicodedata.name(character, "").lower()
    number = f"U+{ord(character):04X}"
    return f"the character {number} ({name})" if name else f"the control character {number}"


def shown(text: str) -> str:
    """A text as it may go to a terminal: one character for each, those that act replaced by pictures of them."""
    return _NOT_PLAIN.sub(_picture, text) if _NOT_PLAIN.search(text) else text


def shown_lines(text: str) -> str:
    """The same for a text of several lines, which stay."""
    return _NOT_PLAIN_LINES.sub(_picture, text)


def brief(text: str, limit: int = 60) -> str:
    """A long text cut in its middle."""
    if len(text) <= limit:
        return text
    half = (limit - 1) // 2
    return f"{text[:half]}…{text[-half:]}"


def _picture(found: re.Match[str]) -> str:
    number = ord(found[0])
    if number < 0x20:
        return chr(_PICTURES + number)
    return "\u2421" if number == 0x7F else "\ufffd"


def same_letters(one: str, other: str) -> bool:
    """Whether two different texts look the same: composed and decomposed accents, no-break blanks."""
    return unicodedata.normalize("NFKC", one) == unicodedata.normalize("NFKC", other)
