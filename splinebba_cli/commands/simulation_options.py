"""Options of ``splinebba simulate``: what is drawn, how often, where it goes."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from splinebba_cli.errors import UsageError


class FigureChoice(StrEnum):
    """Format of figures."""

    svg = "svg"
    png = "png"
    none = "none"


TargetArgument = Annotated[
    str,
    typer.Argument(
        metavar="TARGET",
        help="A kind of block (`list` names them), or a project: its file or folder.",
        show_default=False,
    ),
]
FolderOption = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FOLDER",
        help="Folder to write. Default: KIND in this folder; beside a project, its name with .simulated, "
        ".campaign or .prediction.",
    ),
]
SeedOption = Annotated[
    int | None,
    typer.Option(
        "--seed",
        metavar="NUMBER",
        min=0,
        help="Seed of all errors. Default: as the project says.",
        show_default=False,
    ),
]
NoiseOption = Annotated[
    float | None,
    typer.Option(
        "--noise-um",
        metavar="MICROMETRES",
        min=0.0,
        help="σ of the noise of image coordinates, µm. Default: as declared (kinds: 5).",
    ),
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace a project or campaign that is there.")]
BlunderShareOption = Annotated[
    float | None,
    typer.Option(
        "--blunders", metavar="SHARE", min=0.0, max=0.99, help="Share of image points with a blunder."
    ),
]
BlunderSizeOption = Annotated[
    float | None,
    typer.Option(
        "--blunder-size", metavar="SIGMAS", min=0.0, help="Size of a blunder, in σ of the measurement."
    ),
]
MissingPointsOption = Annotated[
    float | None,
    typer.Option(
        "--missing-points", metavar="SHARE", min=0.0, max=0.99, help="Share of image points dropped."
    ),
]
MissingPairsOption = Annotated[
    float | None,
    typer.Option(
        "--missing-pairs",
        metavar="SHARE",
        min=0.0,
        max=0.99,
        help="Share of pairs of image and feature dropped.",
    ),
]
GivenErrorsOption = Annotated[
    bool | None,
    typer.Option(
        "--given-errors/--given-exact", help="Whether control and priors get errors of their σ. Default: yes."
    ),
]
StartPositionOption = Annotated[
    float | None,
    typer.Option(
        "--start-position", metavar="METRES", min=0.0, help="Largest error of approximate stations, m."
    ),
]
StartAngleOption = Annotated[
    float | None,
    typer.Option(
        "--start-angle", metavar="DEGREES", min=0.0, help="Largest error of approximate angles, degrees."
    ),
]
StartKnotsOption = Annotated[
    float | None,
    typer.Option("--start-knots", metavar="METRES", min=0.0, help="Largest error of approximate knots, m."),
]
RunsOption = Annotated[
    int | None,
    typer.Option(
        "--runs",
        metavar="NUMBER",
        min=1,
        help="Monte Carlo campaign of so many runs; run i has the seed plus i.",
    ),
]
JobsOption = Annotated[
    int | None,
    typer.Option(
        "--jobs", "-j", metavar="NUMBER", min=1, help="Processes of a campaign. Default: all processors."
    ),
]
ResumeOption = Annotated[bool, typer.Option("--resume", help="Continue the campaign that is in the folder.")]
ConfidenceOption = Annotated[
    float,
    typer.Option(
        "--confidence",
        metavar="SHARE",
        min=0.01,
        max=0.9999,
        help="Of the intervals whose coverage is counted.",
    ),
]
StudyOption = Annotated[
    str | None,
    typer.Option(
        "--study",
        metavar="FACTORS",
        help="Convergence study: factors of the errors of the starts, such as 0,1,2,4.",
    ),
]
FiguresOption = Annotated[
    FigureChoice, typer.Option("--figures", help="Format of the figures of a campaign.")
]
PredictOption = Annotated[
    bool, typer.Option("--predict", help="Pre-analysis: predict every σ at the truth; nothing is measured.")
]


def changed_noise(
    noise_um: float | None,
    start_angle_deg: float | None,
    **others: float | bool | None,
) -> dict[str, Any]:
    """Fields of :class:`.simulation.noise.Noise` that the options give."""
    changes: dict[str, Any] = {key: value for key, value in others.items() if value is not None}
    if noise_um is not None:
        changes["image_mm"] = 1e-3 * noise_um
    if start_angle_deg is not None:
        changes["start_angle_rad"] = math.radians(start_angle_deg)
    return changes


def study_factors(text: str | None) -> tuple[float, ...]:
    """The factors of ``--study``, ascending.

    Raises
    ------
    UsageError
        If they are no numbers of at least 0.
    """
    if text is None:
        return ()
    try:
        factors = sorted({float(part) for part in text.split(",")})
    except ValueError:
        factors = [math.nan]
    if not all(math.isfinite(factor) and factor >= 0.0 for factor in factors):
        raise UsageError("SBB900", f"--study {text}: not numbers of at least 0", "such as --study 0,1,2,4")
    return tuple(factors)
