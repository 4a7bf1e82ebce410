"""Building blocks of JSON Schemas that are written by hand."""

from __future__ import annotations

from typing import Any

Schema = dict[str, Any]

NUMBER: Schema = {"type": "number"}
NUMBER_OR_NULL: Schema = {"type": ["number", "null"]}
COUNT: Schema = {"type": "integer", "minimum": 0}
TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
EOP_KEYS = ("x", "y", "z", "omega", "phi", "kappa")


def array_of(items: Schema, length: int | None = None) -> Schema:
    """Schema of an array, of fixed length where it is given."""
    size = {} if length is None else {"minItems": length, "maxItems": length}
    return {"type": "array", "items": items, **size}


def object_of(
    required: dict[str, Schema], optional: dict[str, Schema] | None = None, about: str = ""
) -> Schema:
    """Schema of an object with needed and further properties."""
    described = {"description": about} if about else {}
    properties = {**required, **(optional or {})}
    return {"type": "object", **described, "properties": properties, "required": list(required)}


def xyz_of(about: str = "") -> Schema:
    """Schema of a vector x, y, z."""
    return object_of(dict.fromkeys("xyz", NUMBER_OR_NULL), about=about)
