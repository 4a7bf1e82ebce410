"""What the YAML parser says, in the user's words and at the place to be mended.

The parser notices a quotation or a bracket without an end far behind its beginning; people look for the beginning.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import yaml

from splinebba_cli.project.diagnostics import Collector
from splinebba_cli.project.plain_text import character_name

if TYPE_CHECKING:
    from splinebba_cli.project.yaml_source import YamlSource

_WORD = re.compile(r"[*&!%]?[\w.+-]+(?::(?=\S)[\w.+-]+)*|[*&!%]\S*|\\.")
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_COLON_HELP = "put a text that contains `: ` in quotes, and a blank after the `:` of a key"
_ALIGNED = "keys of one mapping stand below each other, items of one list begin with `- ` below each other"


def report_syntax_error(error: yaml.YAMLError, source: YamlSource, collector: Collector) -> None:
    """Add the diagnostic of an error of the parser."""
    if isinstance(error, yaml.reader.ReaderError):
        _report_character(error, source, collector)
        return
    (line, column), message, help = _explained(error, source)
    text = source.lines[line] if line < len(source.lines) else ""
    word = _WORD.match(text, column)
    place = source.at(line, column, len(word[0]) if word else 1)
    collector.error("SBB102", message, place, help)


def _report_character(error: Any, source: YamlSource, collector: Collector) -> None:
    character = error.character
    character = chr(character) if isinstance(character, int) else character[:1] or "?"
    position = _line_of_offset(source, error.position)
    message = f"{character_name(character)} is not allowed in YAML"
    collector.error(
        "SBB102", message, source.at(*position), "remove it, or write it as an escape in double quotes"
    )


def _line_of_offset(source: YamlSource, offset: int) -> tuple[int, int]:
    for number, line in enumerate(source.lines):
        if offset <= len(line):
            return number, offset
        offset -= len(line) + 1
    return 0, 0


def _explained(error: Any, source: YamlSource) -> tuple[tuple[int, int], str, str]:
    """Position (line and column from 0), message and help."""
    problem, context = str(error.problem or error), str(error.context or "")
    at = source.within(_position(error.problem_mark or error.context_mark))
    begin = source.within(_position(error.context_mark or error.problem_mark))
    sign = source.lines[at[0]][at[1] : at[1] + 1] if source.lines else ""
    if sign == "\t":
        return at, "a tab in the indentation", "indent with blanks"
    if "quoted scalar" in context:
        if "escape" in problem or "hexdecimal" in problem:
            help = "write `\\\\` for a backslash in double quotes, or use single quotes"
            return (
                (at[0], max(0, source.lines[at[0]].rfind("\\", 0, at[1] + 1))),
                "an unknown escape sequence",
                help,
            )
        return (
            begin,
            "a quotation mark without its end",
            "quotation marks come in pairs; within quotes double the mark `'`",
        )
    if "flow" in context:
        return _bracket(at, begin, source)
    if "simple key" in context:
        return begin, "no `:` behind a key", _COLON_HELP
    if "directive" in context or "directive" in problem:
        return begin, "a line that begins with `%`", "put a text that begins with `%` in quotes"
    if "mapping values are not allowed" in problem:
        return at, "a second `:` in a line, or a `:` in a text", _COLON_HELP
    if "cannot start any token" in problem:
        return at, f"nothing can begin with `{sign}`", f"put a text that begins with `{sign}` in quotes"
    if "undefined alias" in problem:
        return (
            at,
            "an alias without its anchor",
            "a value that begins with `*` is an alias; put a text in quotes",
        )
    if "block" in context:
        return at, "the indentation fits to nothing above", _ALIGNED
    return at, f"{problem} ({context})" if context else problem, ""


def _bracket(
    at: tuple[int, int], begin: tuple[int, int], source: YamlSource
) -> tuple[tuple[int, int], str, str]:
    """A list or mapping in brackets: without an end, or without a comma."""
    begin = _last_open_bracket(source) or begin
    opening = source.lines[begin[0]][begin[1] : begin[1] + 1]
    closing = "}" if opening == "{" else "]"
    if at[0] != begin[0] or at[1] >= len(source.lines[at[0]].rstrip()):
        return begin, f"a bracket `{opening}` without its `{closing}`", "brackets come in pairs"
    help = f"the bracket `{opening}` is at column {begin[1] + 1}"
    return at, f"a comma or `{closing}` is missing before this", help


def _last_open_bracket(source: YamlSource) -> tuple[int, int] | None:
    """The innermost bracket that is open where the parser, or the text, ends."""
    opened: list[tuple[int, int]] = []
    try:
        for token in yaml.scan("\n".join(source.lines), Loader=_LOADER):
            if isinstance(token, (yaml.FlowSequenceStartToken, yaml.FlowMappingStartToken)):
                opened.append(_position(token.start_mark))
            elif isinstance(token, (yaml.FlowSequenceEndToken, yaml.FlowMappingEndToken)) and opened:
                opened.pop()
    except yaml.YAMLError:
        pass
    return opened[-1] if opened else None


def _position(mark: Any) -> tuple[int, int]:
    return (0, 0) if mark is None else (mark.line, mark.column)
