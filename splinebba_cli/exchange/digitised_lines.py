"""Digitised lines of a file of points: CSV or GeoJSON, by its name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.errors import PointsFileError
from splinebba_cli.exchange.file_text import JSON_SUFFIXES, text_of
from splinebba_cli.project.diagnostics import Collector, Diagnostic, Place

DEGREES_HELP = (
    "project them to a Cartesian frame in metres (a map projection, a local frame) and fit again; "
    "`--cartesian` says that they are metres already"
)


@dataclass(frozen=True)
class DigitisedLine:
    """Points of one line in their order."""

    id: str  # empty where the file gives none
    points: FloatArray  # (n, 3) metres
    closed: bool = False


@dataclass(frozen=True)
class ReadingOptions:
    """How a file of points is read."""

    columns: tuple[str, ...] | None = None  # CSV: names of x, y, z (and spline) in the header or their order
    height: float | None = None  # z of points that have none, metres
    cartesian: bool = False  # coordinates are metres even if they look like degrees


def read_digitised_lines(
    path: Path, options: ReadingOptions
) -> tuple[tuple[DigitisedLine, ...], tuple[Diagnostic, ...]]:
    """Lines of a file of points, and warnings.

    Parameters
    ----------
    path : Path
        ``.geojson`` and ``.json`` are GeoJSON, everything else is CSV.

    Raises
    ------
    PointsFileError
        With every error of the file.
    """
    from splinebba_cli.exchange.geojson import lines_from_geojson
    from splinebba_cli.exchange.points_csv import lines_from_csv

    collector = Collector()
    text = text_of(path, collector, "fit its lines in parts")
    is_geojson = path.suffix.lower() in JSON_SUFFIXES
    read = lines_from_geojson if is_geojson else lines_from_csv
    lines = [] if text is None else read(text, str(path), options, collector)
    if collector.has_errors or not lines:
        if not collector.has_errors:
            collector.error("SBB405", "there are no lines in the file", Place(str(path)))
        raise PointsFileError(collector.finished())
    return tuple(lines), collector.finished()


def look_like_degrees(points: FloatArray) -> bool:
    """Whether x and y could be longitude and latitude."""
    return bool(np.all(np.abs(points[:, 0]) <= 180.0) and np.all(np.abs(points[:, 1]) <= 90.0))
