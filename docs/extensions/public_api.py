"""Reference of the Python API: ``<!-- api: module.name -->`` in a page becomes what the docstring says.

Fields of dataclasses are explained by the comments behind them; they are read from there.
"""

from __future__ import annotations

import dataclasses
import inspect
import io
import re
import textwrap
import tokenize
from importlib import import_module
from typing import Any

_MARK = re.compile(r"^<!-- api: ([\w.]+) -->$", re.MULTILINE)


def field_comments(cls: type) -> dict[str, str]:
    """Fields of a dataclass with the comment at the end of their line; empty where there is none.

    A field over several lines, in parentheses, has the comment of any of them.
    """
    fields = {field.name for field in dataclasses.fields(cls)}
    comments = dict.fromkeys((field.name for field in dataclasses.fields(cls)), "")
    current = ""
    source = textwrap.dedent(inspect.getsource(cls))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.NAME and token.string in fields and token.start[1] == 4:
            current = token.string
        elif token.type == tokenize.COMMENT and current:
            comments[current] = f"{comments[current]} {token.string.lstrip('# ')}".strip()
        elif token.type == tokenize.NEWLINE:
            current = ""
    return comments


def _directive(match: re.Match[str]) -> str:
    name = match[1]
    module, _, attribute = name.rpartition(".")
    thing = getattr(import_module(module), attribute)
    kind = "autoclass" if inspect.isclass(thing) else "autofunction"
    return f"```{{eval-rst}}\n.. {kind}:: {name}\n```"


def _replace(app: Any, docname: str, source: list[str]) -> None:
    source[0] = _MARK.sub(_directive, source[0])


def _add_fields(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    if what != "class" or not dataclasses.is_dataclass(thing):
        return
    lines += ["", ".. list-table::", "   :widths: auto", ""]
    for field, comment in field_comments(thing).items():
        kind = next(one.type for one in dataclasses.fields(thing) if one.name == field)
        lines += [f"   * - ``{field}``", f"     - ``{kind}``", f"     - {_escaped(comment)}"]


def _escaped(text: str) -> str:
    """Text without markup."""
    return re.sub(r"([*|_`\\])", r"\\\1", text)


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("source-read", _replace)
    app.connect("autodoc-process-docstring", _add_fields)
    return {"parallel_read_safe": True}
