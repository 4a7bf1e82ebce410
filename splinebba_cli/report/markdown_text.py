"""Any text in GitHub-flavoured Markdown: nothing in it is markup, and it keeps to its line."""

from __future__ import annotations

import re

from splinebba_cli.report.printable import one_line

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>#|~$&])")
_ENTITIES = {"<": "&lt;", ">": "&gt;", "&": "&amp;"}


def markdown_text(text: str) -> str:
    """A text as it is."""
    return _SPECIAL.sub(lambda match: _ENTITIES.get(match[0], f"\\{match[0]}"), one_line(text))


def markdown_prose(text: str) -> str:
    """A text of the program, whose `names` in backticks are set as code."""
    parts = re.split(r"`([^`]*)`", text)
    return "".join(_code(part) if number % 2 else markdown_text(part) for number, part in enumerate(parts))


def _code(text: str) -> str:
    return f"<code>{markdown_text(text)}</code>" if text else ""
