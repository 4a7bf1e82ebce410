"""What pydantic finds wrong with a value, in words of the user."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pydantic_core import ErrorDetails

from splinebba_cli.project.plain_text import brief

_COUNTS = ("too_long", "too_short")


def _range(words: str, key: str) -> Callable[[Any, dict[str, Any]], str]:
    return lambda value, context: f"must be {words} {context[key]:g}, not {_text(value)}"


def _expected(what: str) -> Callable[[Any, dict[str, Any]], str]:
    return lambda value, context: f"{what} is expected, not {_text(value)}"


_WORDS: dict[str, Callable[[Any, dict[str, Any]], str]] = {
    "greater_than": _range("greater than", "gt"),
    "greater_than_equal": _range("at least", "ge"),
    "less_than": _range("less than", "lt"),
    "less_than_equal": _range("at most", "le"),
    "bool_parsing": _expected("true or false"),
    "bool_type": _expected("true or false"),
    "int_parsing": _expected("a whole number"),
    "int_parsing_size": _expected("a whole number of at most 4000 digits"),
    "int_from_float": _expected("a whole number"),
    "int_type": _expected("a whole number"),
    "string_type": _expected("a text"),
    "list_type": _expected("a list"),
    "tuple_type": _expected("a list"),
    "dict_type": _expected("a mapping"),
    "model_type": _expected("a mapping (`key: value`)"),
    "model_attributes_type": _expected("a mapping (`key: value`)"),
}

EXAMPLES = {
    "version": "version: 1",
    "project": "project: {name: harbour, angle_unit: deg, rotation_sequence: omega-phi-kappa}",
    "cameras": "cameras: [{id: cam, principal_distance_mm: 100.5, image_coordinates: photo_mm}]",
    "images": "images: {table: images.csv, camera: cam}",
}

HELP_FOR_NAMES = (
    "ids and names stand in every output: choose one that terminals, tables and CI logs take for a mere text"
)


def words_of(detail: ErrorDetails, owner: Any) -> str:
    """The message of a detail; `owner` is the value at its place, as the user wrote it."""
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    if kind in _COUNTS:
        needed = context.get("max_length", context.get("min_length"))
        how = "at most " if kind == "too_long" else "at least "
        count = len(owner) if isinstance(owner, list) else context.get("actual_length")
        return f"{how}{needed} values are expected, not {count}"
    if kind in _WORDS:
        return _WORDS[kind](value, context)
    text = detail["msg"]
    text = text[0].lower() + text[1:] if text and not text.startswith("`") else text
    shown = f" (`{value}`)" if isinstance(value, str) and len(value) < 40 and value not in text else ""
    return text + shown


def _text(value: Any) -> str:
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return "a list"
    return f"`{brief(str(value))}`" if str(value) else "an empty text"
