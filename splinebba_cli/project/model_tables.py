"""Tables in the project file: inline rows or a side table."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from splinebba_cli.project.scalars import AlsoJson, Delimiter, FileName, Model


def _data(value: Any) -> Any:
    """Rows as a block scalar, or as a list of rows; each row of the result is a text or a tuple of texts."""
    if isinstance(value, str):
        return value
    if isinstance(value, (list, tuple)):
        for number, row in enumerate(value):
            if not isinstance(row, (list, tuple)) or any(isinstance(cell, (list, dict)) for cell in row):
                raise PydanticCustomError("rows", "row {n} is not a list of values", {"n": number})
        return tuple(tuple("" if cell is None else str(cell) for cell in row) for row in value)
    raise PydanticCustomError("rows", "rows are a block scalar (`|`, one row a line) or a list of lists")


_ROWS_SCHEMA: dict[str, Any] = {
    "anyOf": [
        {"type": "string"},
        {
            "type": "array",
            "items": {"type": "array", "items": {"type": ["string", "number", "boolean", "null"]}},
        },
    ]
}

Rows = Annotated[str | tuple[tuple[str, ...], ...], BeforeValidator(_data), WithJsonSchema(_ROWS_SCHEMA)]


def _columns(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        value = tuple(str(item) if item is not None else "-" for item in value)
        named = [item for item in value if item != "-"]
        twice = sorted({item for item in named if named.count(item) > 1})
        if twice:
            raise PydanticCustomError("columns", "column `{name}` declared twice", {"name": twice[0]})
        return value
    if isinstance(value, dict):
        return value
    raise PydanticCustomError(
        "columns", "columns are a list of names, or a mapping of our names to those of the header"
    )


Columns = Annotated[
    tuple[str, ...] | dict[str, str],
    BeforeValidator(_columns),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "array", "items": {"type": "string"}, "minItems": 1},
                {"type": "object", "additionalProperties": {"type": ["string", "number"]}},
            ]
        }
    ),
]


class TableOptions(Model):
    """A side table: file, columns, delimiter."""

    table: FileName | None = Field(
        default=None, description="Side table, CSV or Parquet; relative to the project file."
    )
    columns: Columns | None = Field(
        default=None,
        description=(
            "Names of the columns in their order (`-`: not used; the table then has no header), "
            "or a mapping of these names to those of the header. Without it the header must have these names."
        ),
    )
    header: bool | None = Field(
        default=None, description="Whether the first row names the columns (default: see `columns`)."
    )
    delimiter: Delimiter = Field(
        default="auto",
        description="auto: tab, semicolon, comma or blanks, whichever the first row has, in this order.",
    )


class TableOrRows(TableOptions):
    """A side table, or rows in the project file."""

    data: Rows | None = Field(
        default=None, description="Rows: a block scalar, one row a line, or a list of lists."
    )


class NumberTable(TableOrRows):
    """Rows of knots or coefficients, here or in a side table with a column that names the spline."""


def _number_rows(value: Any) -> Any:
    """Knots may be written as rows at once, or as a mapping with a table."""
    return {"data": value} if isinstance(value, (str, list, tuple)) else value


KnotRows = Annotated[
    NumberTable,
    BeforeValidator(_number_rows),
    AlsoJson(*_ROWS_SCHEMA["anyOf"]),
]
