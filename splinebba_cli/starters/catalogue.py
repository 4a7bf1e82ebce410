"""The starters by name; nothing heavy is imported here, so that the command line can complete the names."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinebba_cli.project.diagnostics import Diagnostic

TEMPLATES: dict[str, str] = {
    "aerial": "two strips of four aerial images: control, check and tie points, roads and a pond as tie splines, "
    "observed exterior orientations (GNSS/INS)",
    "close-range": "eight convergent images of an object: targets, a circle and two edges, a scale bar, no approximate "
    "orientations",
    "control-splines": "a flight over lines that are known, as splines fitted to a polyline (--polyline FILE, else one "
    "of the program): control without control points",
}
DEFAULT = "aerial"
OF_POLYLINES = "control-splines"


@dataclass(frozen=True)
class Polyline:
    """A file of digitised lines, and how it is read; see :mod:`splinebba_cli.exchange.digitised_lines`."""

    file: Path
    columns: tuple[str, ...] | None = None
    height: float | None = None  # z of points that have none, metres
    cartesian: bool = False
    threshold_m: float = 0.05  # no point is farther from its spline


@dataclass(frozen=True)
class Starter:
    """The files of a project, name to content, and what reading its polyline has found."""

    files: dict[str, str]
    warnings: tuple[Diagnostic, ...] = ()


def build(template: str, polyline: Polyline | None = None) -> Starter:
    """The files of a starter; the same ones for the same arguments.

    Parameters
    ----------
    template : a key of :data:`TEMPLATES`
    polyline : for ``control-splines`` alone; None: the lines of the program

    Raises
    ------
    PointsFileError, FitError
        If the polyline is not one.
    UsageError
        SBB821, if it cannot carry a block.
    """
    module = importlib.import_module(f"splinebba_cli.starters.{template.replace('-', '_')}")
    if template == OF_POLYLINES:
        made: Starter = module.starter(polyline)
        return made
    starter: Callable[[], Starter] = module.starter
    return starter()
