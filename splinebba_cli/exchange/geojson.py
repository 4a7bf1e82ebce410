"""Digitised lines in GeoJSON: LineString, MultiLineString, rings of Polygon and MultiPolygon.

RFC 7946 says that coordinates are longitude and latitude; measured lines are often written in a projected
frame all the same, with or without the member ``crs`` of the older specification (2008).  Degrees are refused.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.digitised_lines import (
    DEGREES_HELP,
    DigitisedLine,
    ReadingOptions,
    look_like_degrees,
)
from splinebba_cli.exchange.geojson_geometry import NotGeojsonError, named_lines
from splinebba_cli.exchange.json_file import NoJsonError, json_of
from splinebba_cli.project.diagnostics import Collector, Place
from splinebba_cli.project.plain_text import id_problem
from splinebba_cli.project.scalars import LARGEST_NUMBER

GEOGRAPHIC = ("CRS84", "EPSG::4326", "EPSG:4326", "EPSG::4979", "EPSG:4979", "EPSG::4258", "EPSG:4258")
ID_PROPERTIES = ("id", "name")


def lines_from_geojson(
    text: str, file: str, options: ReadingOptions, collector: Collector
) -> list[DigitisedLine]:
    """Lines of a GeoJSON text; errors go to the collector.

    The id of a line is the property ``id`` or ``name`` of its feature, or the feature's id; the parts of a multiple
    geometry get a number behind it.
    """
    place = Place(file)
    try:
        data = json_of(text, file, "SBB407", collector)
        lines, passed_over = _lines(data, options)
    except NoJsonError:
        return []
    except NotGeojsonError as error:
        collector.error("SBB407", f"not GeoJSON: {error}", place)
        return []
    if passed_over:
        kinds = ", ".join(sorted(set(passed_over)))
        collector.warning(
            "SBB407", f"{len(passed_over)} geometries that are no lines left out: {kinds}", place
        )
    for line in lines:
        _check_coordinates(line, options, place, collector)
    if lines and not options.cartesian and not collector.has_errors:
        _check_frame(data, lines, place, collector)
    return lines


def _lines(data: Any, options: ReadingOptions) -> tuple[list[DigitisedLine], list[str]]:
    passed_over: list[str] = []
    lines = [
        DigitisedLine(line.name, _array(line.positions, options.height), line.closed)
        for line in named_lines(data, ID_PROPERTIES, passed_over)
    ]
    return lines, passed_over


def _array(positions: list[list[float]], height: float | None) -> FloatArray:
    """Positions, (n, 3); a height that is missing is given or NaN."""
    missing = math.inf if height is None else height
    return np.array([[*row[:3], missing][:3] for row in positions], dtype=float).reshape(-1, 3)


def _check_coordinates(
    line: DigitisedLine, options: ReadingOptions, place: Place, collector: Collector
) -> None:
    name = f"line `{line.id}`" if line.id else "a line"
    if line.id and (problem := id_problem(line.id)):
        help = "give another property `id` or `name`"
        collector.error("SBB210", f"the id of {name} {problem}", place, help, kind="ids of lines")
    if np.isposinf(line.points[:, 2]).any() and options.height is None:
        help = "`--z METRES` gives them this height"
        collector.error("SBB322", f"{name} has points without a height", place, help, kind="heights")
    elif not (np.abs(line.points) <= LARGEST_NUMBER).all():
        message = f"{name} has coordinates that are not finite, or more than {LARGEST_NUMBER:.0e}"
        collector.error("SBB403", message, place, kind="coordinates")


def _check_frame(data: Any, lines: list[DigitisedLine], place: Place, collector: Collector) -> None:
    name = _crs_name(data)
    if name.endswith(GEOGRAPHIC):
        collector.error("SBB321", f"the coordinates are degrees: crs `{name}`", place, DEGREES_HELP)
    elif not name and all(look_like_degrees(line.points) for line in lines):
        message = "the coordinates are longitudes and latitudes, by their size and by the rule of GeoJSON"
        collector.error("SBB321", message, place, DEGREES_HELP)


def _crs_name(data: dict[str, Any]) -> str:
    crs = data.get("crs")
    properties = crs.get("properties") if isinstance(crs, dict) else None
    return str(properties.get("name", "")) if isinstance(properties, dict) else ""
