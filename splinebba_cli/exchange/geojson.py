"""Digitised lines in GeoJSON: LineString, MultiLineString, rings of Polygon and MultiPolygon.

RFC 7946 says that coordinates are longitude and latitude; measured lines are often written in a projected
frame all the same, with or without the member ``crs`` of the older specification (2008).  Degrees are refused.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.exchange.digitised_lines import (
    DEGREES_HELP,
    DigitisedLine,
    ReadingOptions,
    look_like_degrees,
)
from splinebba_cli.project.diagnostics import Collector, Place
from splinebba_cli.project.plain_text import id_problem
from splinebba_cli.project.scalars import LARGEST_NUMBER

GEOGRAPHIC = ("CRS84", "EPSG::4326", "EPSG:4326", "EPSG::4979", "EPSG:4979", "EPSG::4258", "EPSG:4258")
ID_PROPERTIES = ("id", "name")


class _NotGeojsonError(Exception):
    """What is wrong."""


def lines_from_geojson(
    text: str, file: str, options: ReadingOptions, collector: Collector
) -> list[DigitisedLine]:
    """Lines of a GeoJSON text; errors go to the collector.

    The id of a line is the property ``id`` or ``name`` of its feature, or the feature's id; the parts of a multiple
    geometry get a number behind it.
    """
    place = Place(file)
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        at = Place(file, error.lineno, error.colno, 1, _line(text, error.lineno))
        collector.error("SBB407", f"not JSON: {error.msg}", at)
        return []
    except RecursionError:
        collector.error("SBB407", "nested too deeply", place)
        return []
    try:
        lines, passed_over = _lines(data, options)
    except _NotGeojsonError as error:
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


def _line(text: str, number: int) -> str:
    lines = text.splitlines()
    return lines[number - 1] if number <= len(lines) else ""


def _lines(data: Any, options: ReadingOptions) -> tuple[list[DigitisedLine], list[str]]:
    lines, passed_over = [], []
    for id, geometry in _geometries(data):
        kind = geometry.get("type")
        parts = list(_parts(geometry))
        if not parts:
            passed_over.append(str(kind))
        for number, (closed, rows) in enumerate(parts):
            name = f"{id}-{number + 1}" if id and len(parts) > 1 else id
            lines.append(DigitisedLine(name, _array(rows, options.height), closed))
    return lines, passed_over


def _geometries(data: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Geometries with the ids of their features."""
    if not isinstance(data, dict) or not isinstance(data.get("type"), str):
        raise _NotGeojsonError("no object with a `type`")
    if data["type"] == "FeatureCollection":
        features = data.get("features")
        if not isinstance(features, list):
            raise _NotGeojsonError("a FeatureCollection without a list of `features`")
        for feature in features:
            yield from _geometries(feature)
    elif data["type"] == "Feature":
        properties = data.get("properties") if isinstance(data.get("properties"), dict) else {}
        assert isinstance(properties, dict)
        found = next((properties[key] for key in ID_PROPERTIES if properties.get(key) is not None), None)
        found = data.get("id") if found is None else found
        if isinstance(data.get("geometry"), dict):
            for _, geometry in _geometries(data["geometry"]):
                yield ("" if found is None else str(found).strip()), geometry
    elif data["type"] == "GeometryCollection":
        for geometry in data.get("geometries") or []:
            yield from _geometries(geometry)
    else:
        yield "", data


def _parts(geometry: dict[str, Any]) -> Iterator[tuple[bool, Any]]:
    """Whether it is closed, and the positions of every line of a geometry."""
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    if kind not in ("LineString", "MultiLineString", "Polygon", "MultiPolygon"):
        return
    if not isinstance(coordinates, list):
        raise _NotGeojsonError(f"a {kind} without a list of `coordinates`")
    nested = coordinates
    if kind == "LineString":
        nested = [coordinates]
    elif kind == "MultiPolygon":
        nested = [ring for polygon in coordinates if isinstance(polygon, list) for ring in polygon]
    for rows in nested:
        yield kind.endswith("Polygon"), rows


def _array(rows: Any, height: float | None) -> FloatArray:
    """Positions, (n, 3); a height that is missing is given or NaN."""
    out = []
    for row in rows if isinstance(rows, list) else [None]:
        if not isinstance(row, list) or len(row) < 2 or not all(map(_is_number, row)):
            raise _NotGeojsonError(f"`{json.dumps(row)[:60]}` is no position")
        out.append([*row[:3], math.inf if height is None else height][:3])
    return np.array(out, dtype=float).reshape(-1, 3)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


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
