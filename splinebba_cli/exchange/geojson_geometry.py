"""Lines in the data of a GeoJSON file: LineString, MultiLineString, rings of Polygon and MultiPolygon (RFC 7946)."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

Members = dict[str, Any]


class NotGeojsonError(Exception):
    """What is wrong."""


def geometries(data: Any, feature: Members | None = None) -> Iterator[tuple[Members, Members]]:
    """Geometries with their features; that of a geometry without one is empty.

    Raises
    ------
    NotGeojsonError
    """
    if not isinstance(data, dict) or not isinstance(data.get("type"), str):
        raise NotGeojsonError("no object with a `type`")
    if data["type"] == "FeatureCollection":
        features = data.get("features")
        if not isinstance(features, list):
            raise NotGeojsonError("a FeatureCollection without a list of `features`")
        for each in features:
            yield from geometries(each)
    elif data["type"] == "Feature":
        if isinstance(data.get("geometry"), dict):
            yield from geometries(data["geometry"], data)
    elif data["type"] == "GeometryCollection":
        for geometry in data.get("geometries") or []:
            yield from geometries(geometry, feature)
    else:
        yield feature or {}, data


def property_of(feature: Members, names: Sequence[str]) -> str:
    """The first of some properties that a feature has; empty where it has none."""
    properties = feature.get("properties")
    if not isinstance(properties, dict):
        return ""
    found = next((properties[name] for name in names if properties.get(name) is not None), None)
    return "" if found is None else str(found).strip()


def feature_id(feature: Members, names: Sequence[str]) -> str:
    """The id of a feature among its properties, else its own; empty where it has none."""
    own = feature.get("id")
    return property_of(feature, names) or ("" if own is None else str(own).strip())


@dataclass(frozen=True)
class NamedLine:
    """One line of a geometry."""

    name: str  # of its feature, with a number where the geometry has several lines; empty where there is none
    feature: Members
    closed: bool
    positions: list[list[float]]  # two numbers or more each


def named_lines(data: Any, properties: Sequence[str], passed_over: list[str]) -> Iterator[NamedLine]:
    """All lines of the data of a file.

    Parameters
    ----------
    properties : of features, that may hold the name; else the feature's id
    passed_over : gets the kinds of geometries that are no lines

    Raises
    ------
    NotGeojsonError
    """
    for feature, geometry in geometries(data):
        found = list(parts(geometry))
        if not found:
            passed_over.append(str(geometry.get("type")))
        name = feature_id(feature, properties)
        for number, (closed, rows) in enumerate(found, start=1):
            yield NamedLine(part_name(name, number, len(found)), feature, closed, positions(rows))


def parts(geometry: Members) -> Iterator[tuple[bool, Any]]:
    """Whether it is closed, and the positions of every line of a geometry; none of one that is no line.

    Raises
    ------
    NotGeojsonError
    """
    kind, coordinates = geometry.get("type"), geometry.get("coordinates")
    if kind not in ("LineString", "MultiLineString", "Polygon", "MultiPolygon"):
        return
    if not isinstance(coordinates, list):
        raise NotGeojsonError(f"a {kind} without a list of `coordinates`")
    nested = coordinates
    if kind == "LineString":
        nested = [coordinates]
    elif kind == "MultiPolygon":
        nested = [ring for polygon in coordinates if isinstance(polygon, list) for ring in polygon]
    for rows in nested:
        yield kind.endswith("Polygon"), rows


def positions(rows: Any) -> list[list[float]]:
    """The positions of a line: two numbers or more each.

    Raises
    ------
    NotGeojsonError
    """
    out = []
    for row in rows if isinstance(rows, list) else [None]:
        if not isinstance(row, list) or len(row) < 2 or not all(map(_is_number, row)):
            raise NotGeojsonError(f"`{json.dumps(row)[:60]}` is no position")
        out.append(row)
    return out


def part_name(name: str, number: int, of: int) -> str:
    """The name of a part of a geometry: with a number behind it where there are several."""
    return f"{name}-{number}" if name and of > 1 else name


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
