"""Write docs/command-line.md from the signatures of the commands.

python -m docs.build_command_line
"""

from __future__ import annotations

import inspect
import types
import typing
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from typer.models import ArgumentInfo, OptionInfo

from splinebba_cli.commands.app import app

PAGE = Path(__file__).with_name("command-line.md")
INTRODUCTION = Path(__file__).with_name("command-line.intro.md")
KINDS = {int: "whole number", float: "number", str: "text", Path: "path"}


@dataclass(frozen=True)
class Parameter:
    """An argument or option of a command."""

    name: str
    kind: Any  # type of one value
    default: Any  # inspect.Parameter.empty: needed
    info: Any  # typer's ArgumentInfo or OptionInfo


def page() -> str:
    """The whole page."""
    parts = [INTRODUCTION.read_text(encoding="utf-8").rstrip()]
    parts += [_section(one.name or "", one.callback) for one in app.registered_commands if one.callback]
    return "\n\n".join(parts) + "\n"


def parameters_of(callback: Callable[..., Any]) -> list[Parameter]:
    """Parameters of a command in their order."""
    hints = typing.get_type_hints(callback, include_extras=True)
    found = []
    for name, parameter in inspect.signature(callback).parameters.items():
        kind, *extras = typing.get_args(hints[name])
        info = next((one for one in extras if isinstance(one, ArgumentInfo | OptionInfo)), None)
        if info is not None:
            found.append(Parameter(name, _one_of(kind), parameter.default, info))
    return found


def _one_of(kind: Any) -> Any:
    """The type of one value: of `T | None` and lists T."""
    if typing.get_origin(kind) in (types.UnionType, typing.Union):
        kind = next(one for one in typing.get_args(kind) if one is not type(None))
    return typing.get_args(kind)[0] if typing.get_origin(kind) is list else kind


def _section(name: str, callback: Callable[..., Any]) -> str:
    parameters = parameters_of(callback)
    arguments = [one for one in parameters if isinstance(one.info, ArgumentInfo)]
    options = [one for one in parameters if isinstance(one.info, OptionInfo)]
    needed = [inspect.Parameter.empty, ...]
    shown = [_argument(one) if one.default in needed else f"[{_argument(one)}]" for one in arguments]
    usage = " ".join(["splinebba", name, *(["[OPTIONS]"] if options else []), *shown])
    lines = [f"### {name}", "", _cell(inspect.getdoc(callback) or ""), "", f"    {usage}"]
    if arguments:
        lines += ["", "| argument | meaning |", "|---|---|"]
        lines += [
            f"| `{_argument(one)}` | {_cell(one.info.help or '')}{_choices(one)} |" for one in arguments
        ]
    if options:
        lines += ["", "| option | value | default | meaning |", "|---|---|---|---|"]
        lines += [_option(one) for one in options]
    return "\n".join(lines)


def _argument(one: Parameter) -> str:
    return str(one.info.metavar or one.name.upper()).strip("[]{}")


def _choices(one: Parameter) -> str:
    return f" {_value(one)}." if inspect.isclass(one.kind) and issubclass(one.kind, Enum) else ""


def _option(one: Parameter) -> str:
    cells = (
        ", ".join(f"`{name}`" for name in _names(one)),
        _value(one),
        _default(one),
        _cell(one.info.help or ""),
    )
    return f"| {' | '.join(cells)} |"


def _names(one: Parameter) -> list[str]:
    """Names of an option, the one that switches off behind that which switches on."""
    first = [one.info.default] if str(one.info.default).startswith("-") else []
    declared = [*first, *(one.info.param_decls or ())] or [f"--{one.name.replace('_', '-')}"]
    return [part for name in declared for part in name.split("/")]


def _value(one: Parameter) -> str:
    if one.kind is bool or getattr(one.info, "count", False):
        return ""
    if one.info.metavar:
        return f"`{one.info.metavar}`"
    if inspect.isclass(one.kind) and issubclass(one.kind, Enum):
        return ", ".join(f"`{choice.value}`" for choice in one.kind)
    least, most = one.info.min, one.info.max
    limits = (
        f", {least:g} to {most:g}"
        if most is not None
        else f", {least:g} or more"
        if least is not None
        else ""
    )
    return KINDS.get(one.kind, "text") + limits


def _default(one: Parameter) -> str:
    if one.kind is bool:
        switches = [name for name in _names(one) if name.startswith("--")]
        return (
            f"`{switches[0 if one.default else 1]}`" if len(switches) == 2 and one.default is not None else ""
        )
    if one.default in (None, inspect.Parameter.empty, ..., "") or one.info.count:
        return ""
    return f"`{getattr(one.default, 'value', one.default)}`"


def _cell(text: str) -> str:
    """Text in a cell of a table."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "\\<")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
    print(PAGE.name)
