"""JSON as people like to read it: objects indented, rows of numbers on one line; same data, same text."""

from __future__ import annotations

import json
import math
import re
from functools import lru_cache
from json.encoder import encode_basestring
from typing import Any

import numpy as np

_WIDTH = 140
_SCALARS = (str, int, float, bool, type(None))
_FLAT = frozenset(_SCALARS)
_NUMBERS = frozenset((int, float))
_NUMBERS_ONLY = re.compile(r"[\[\]0-9e+\-., ]*")
_SHORT = 4  # elements of a list that is one of several on a line
_encode = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


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
        return _scalar(value)
    if not value:
        return "{}" if isinstance(value, dict) else "[]"
    deeper = indent + "  "
    if type(value) is list and (of_numbers := _of_numbers(value, indent, deeper)) is not None:
        return of_numbers
    children = list(value.values()) if isinstance(value, dict) else list(value)
    keys = list(map(_key, value)) if isinstance(value, dict) else None
    kinds = set(map(type, children))
    flat = kinds <= _FLAT or all(map(_is_flat, children))
    if flat:
        texts = list(map(_line, children))
        items = texts if keys is None else list(map(str.__add__, keys, texts))
        if sum(map(len, items)) + 2 * len(items) <= _WIDTH:
            return f"[{', '.join(items)}]" if keys is None else f"{{{', '.join(items)}}}"
        if keys is None and kinds <= _FLAT:
            return _wrapped(texts, indent, deeper)
    if not flat or max(map(len, texts)) > _WIDTH:
        texts = [_scalar(child) if type(child) in _FLAT else _text(child, deeper) for child in children]
    between = f",\n{deeper}"
    if keys is None:
        return f"[\n{deeper}{between.join(texts)}\n{indent}]"
    return f"{{\n{deeper}{between.join(map(str.__add__, keys, texts))}\n{indent}}}"


def _of_numbers(value: list[Any], indent: str, deeper: str) -> str | None:
    """A list of numbers, or of short lists of numbers, as Python writes it; None of anything else."""
    first = value[0]
    if type(first) is list and first:
        first = first[0]
    if type(first) not in _NUMBERS:
        return None
    text = repr(value)
    if _NUMBERS_ONLY.fullmatch(text.replace("None", "")) is None:
        return None
    lists = text.count("[") - 1
    if lists and (lists != len(value) or set(map(type, value)) != {list} or max(map(len, value)) > _SHORT):
        return None
    text = text.replace("None", "null")
    if len(text) <= _WIDTH:
        return text
    if not lists:
        return _wrapped(text[1:-1].split(", "), indent, deeper)
    return f"[\n{deeper}{text[1:-1].replace('], [', f'],{chr(10)}{deeper}[')}\n{indent}]"


@lru_cache(maxsize=1024, typed=True)
def _key(key: Any) -> str:
    return f"{_scalar(str(key))}: "


def _line(value: Any) -> str:
    """A scalar or a short list of scalars."""
    if type(value) is not list:
        return _scalar(value)
    if _NUMBERS.issuperset(map(type, value)) and "n" not in (text := repr(value)):  # no nan, inf
        return text
    return f"[{', '.join(map(_scalar, value))}]"


def _scalar(value: Any) -> str:
    kind = type(value)
    if kind is float and math.isfinite(value):
        return repr(value)
    if kind is str:
        return encode_basestring(value)
    if kind is int:
        return repr(value)
    if value is None:
        return "null"
    return _encode(value)


def _is_flat(value: Any) -> bool:
    kind = type(value)
    return kind in _FLAT or (kind is list and len(value) <= _SHORT and _FLAT.issuperset(map(type, value)))


def _wrapped(scalars: list[str], indent: str, deeper: str) -> str:
    """A long list of the texts of scalars, several on a line."""
    lines, line = [], ""
    for item in scalars:
        if line and len(line) + len(item) + 2 > _WIDTH:
            lines.append(line)
            line = ""
        line = f"{line}, {item}" if line else item
    lines.append(line)
    return "[\n" + ",\n".join(deeper + line for line in lines) + f"\n{indent}]"


def finite(value: Any) -> Any:
    """Arrays as lists, numpy numbers as Python numbers, NaN and infinities as None, at any depth."""
    kind = type(value)
    if kind is str or kind is int or value is None:
        return value
    if kind is float:
        return value + 0.0 if math.isfinite(value) else None
    if kind is dict:
        return {key: finite(item) for key, item in value.items()}
    if kind is np.ndarray and value.dtype.kind == "f" and value.ndim:
        return _finite_array(value)
    if hasattr(value, "tolist"):
        return finite(value.tolist())
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(item) for item in value]
    return value


def _finite_array(values: Any) -> list[Any]:
    if np.isfinite(values).all():
        return list((values + 0.0).tolist())
    if values.ndim > 1:
        return [_finite_array(row) for row in values]
    return [x + 0.0 if math.isfinite(x) else None for x in values.tolist()]
