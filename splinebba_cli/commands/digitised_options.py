"""Options of the commands that read digitised lines."""

from __future__ import annotations

from typing import Annotated

import typer

ThresholdOption = Annotated[
    float,
    typer.Option("--threshold-m", metavar="METRES", help="No point is farther from its spline than this, m."),
]
ColumnsOption = Annotated[
    str | None,
    typer.Option("--columns", metavar="NAMES", help="Columns of a CSV: x,y,z[,spline], by name or in order."),
]
HeightOption = Annotated[
    float | None, typer.Option("--z", metavar="METRES", help="Height of points without one, m.")
]
CartesianOption = Annotated[
    bool, typer.Option("--cartesian", help="Coordinates are metres although they look like degrees.")
]


def column_names(columns: str | None) -> tuple[str, ...] | None:
    """The names of the option ``--columns``."""
    return None if columns is None else tuple(name.strip() for name in columns.split(","))
