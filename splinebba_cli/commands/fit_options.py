"""Options of ``splinebba fit``: how the lines are fitted, what the splines are for, what is written."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class ParameterizationChoice(StrEnum):
    """Locations with which a fit begins."""

    chord_length = "chord_length"
    uniform = "uniform"


class RoleChoice(StrEnum):
    """Role of a spline."""

    tie = "tie"
    control = "control"
    check = "check"
    partial = "partial"


PointsArgument = Annotated[
    Path,
    typer.Argument(
        metavar="POINTS",
        help="Digitised points: CSV (x, y, z and, for several lines, spline) or GeoJSON; metres.",
        show_default=False,
    ),
]
FileOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="YAML to write, `-` for stdout. Default: POINTS.splines.yaml beside it.",
    ),
]
ClosedOption = Annotated[bool, typer.Option("--closed", help="The lines are closed.")]
ParameterizationOption = Annotated[
    ParameterizationChoice,
    typer.Option("--parameterization", help="Locations of the points at the start of the fit."),
]
IdOption = Annotated[
    str | None,
    typer.Option("--id", metavar="ID", help="Id of the spline; of several: with a number behind it."),
]
RoleOption = Annotated[RoleChoice, typer.Option("--role", help="Role of the splines.")]
SigmaOption = Annotated[
    str | None,
    typer.Option(
        "--sigma", metavar="METRES", help="σ of the knots, m, or `fixed`: control and partial need it."
    ),
]
CornerAngleOption = Annotated[
    float | None,
    typer.Option(
        "--corner-angle",
        metavar="DEGREES",
        help="Corners where the points turn by more than so many degrees.",
    ),
]
FigureOption = Annotated[
    Path | None, typer.Option("--figure", metavar="FILE", help="Figure to draw: svg, png or pdf.")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace files that are there.")]
