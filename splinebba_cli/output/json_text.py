"""JSON as people like to read it: objects indented, rows of numbers on one line; same data, same text."""

from __future__ import annotations

import json
import math
from typing import Any

_WIDTH = 140
_SCALARS = (str, int, float, bool, type(None))


def json_text(value: Any) -> str:
    """JSON of dicts, lists, text, numbers; keys keep their order, floats are the shortest that read back.

    Raises
    ------
    ValueError
        If a number is not finite: JSON has no such numbers (use None).
    """
    return _text(value, "") + "\n"


def _text(value: Any, indent: str) -> str:
    if isinstance(value, _SCALARS):
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    deeper = indent + "  "
    children = list(value.values()) if isinstance(value, dict) else list(value)
    if not children:
        return "{}" if isinstance(value, dict) else "[]"
    if all(_is_flat(child) for child in children):
        line = json.dumps(value, ensure_ascii=False, allow_nan=False)
        if len(line) <= _WIDTH:
            return line
    if isinstance(value, dict):
        inner = (
            f"{deeper}{json.dumps(str(k), ensure_ascii=False)}: {_text(v, deeper)}" for k, v in value.items()
        )
        return "{\n" + ",\n".join(inner) + f"\n{indent}}}"
    if all(isinstance(child, _SCALARS) for child in children):
        return _wrapped(children, indent, deeper)
    return "[\n" + ",\n".join(deeper + _text(child, deeper) for child in children) + f"\n{indent}]"


def _is_flat(value: Any) -> bool:
    return isinstance(value, _SCALARS) or (
        isinstance(value, list) and len(value) <= 4 and all(isinstance(x, _SCALARS) for x in value)
    )


def _wrapped(scalars: list[Any], indent: str, deeper: str) -> str:
    """A long list of scalars, several on a line."""
    lines, line = [], ""
    for scalar in scalars:
        item = json.dumps(scalar, ensure_ascii=False, allow_nan=False)
        if line and len(line) + len(item) + 2 > _WIDTH:
            lines.append(line)
            line = ""
        line = f"{line}, {item}" if line else item
    lines.append(line)
    return "[\n" + ",\n".join(deeper + line for line in lines) + f"\n{indent}]"


def finite(value: Any) -> Any:
    """Arrays as lists, numpy numbers as Python numbers, NaN and infinities as None, at any depth."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    return value
