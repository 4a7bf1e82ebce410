"""Options of ``splinebba chains``: how files of tracing tools are read, and which of their points stay."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

FilesArgument = Annotated[
    list[Path],
    typer.Argument(
        metavar="FILES...",
        help="Traced chains: GeoJSON, labelme, tables of points or segments; image coordinates.",
        show_default=False,
    ),
]
FileOption = Annotated[
    Path,
    typer.Option("--output", "-o", metavar="FILE", help="Table to write, `-` for stdout."),
]
ColumnsOption = Annotated[
    str | None,
    typer.Option(
        "--columns",
        metavar="NAMES",
        help="Columns of tables in their order: x1,y1,x2,y2 or x,y or row,col; image, chain; `-`: not used.",
    ),
]
ImageSuffixOption = Annotated[
    str,
    typer.Option(
        "--image-suffix",
        metavar="TEXT",
        help="Put behind names of images that are names of files, as in `.JPG`.",
        show_default=False,
    ),
]
YUpOption = Annotated[
    float | None,
    typer.Option(
        "--y-up",
        metavar="TOP",
        help="y points up and is TOP at the upper edge: 0, or the height of the image; turned down.",
    ),
]
SpacingOption = Annotated[
    float | None,
    typer.Option(
        "--spacing", metavar="PX", help="Thin chains: points at least so far apart along the chain."
    ),
]
MinPointsOption = Annotated[
    int,
    typer.Option("--min-points", metavar="N", min=1, help="Leave out chains with fewer points."),
]
RenumberOption = Annotated[
    bool, typer.Option("--renumber", help="Number the chains of every image; pass over their names.")
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace a file that is there.")]
