"""Options of ``splinebba match``; without one, the section `matching` of the project says it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

FolderOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FOLDER",
        help="Folder to write; replaced as a whole. Default: PROJECT.matched beside it.",
    ),
]
NewCurvesOption = Annotated[
    bool | None,
    typer.Option(
        "--new-curves/--no-new-curves",
        help="Whether splines are built from chains that no spline explains. Default: as the project says.",
        show_default=False,
    ),
]
AlphaOption = Annotated[
    float | None,
    typer.Option(
        "--alpha",
        metavar="SHARE",
        min=1e-9,
        max=0.5,
        help="Share of right points that the gate may lose. Default: as the project says.",
        show_default=False,
    ),
]
RoundsOption = Annotated[
    int | None,
    typer.Option(
        "--rounds",
        metavar="N",
        min=1,
        max=1000,
        help="Largest number of rounds. Default: as the project says.",
        show_default=False,
    ),
]
SeedOption = Annotated[
    int | None,
    typer.Option(
        "--seed",
        metavar="N",
        min=0,
        help="Seed of all random choices. Default: as the project says.",
        show_default=False,
    ),
]
HtmlOption = Annotated[bool, typer.Option("--html/--no-html", help="Whether match.html is written.")]
