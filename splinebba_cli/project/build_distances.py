"""Distances between points or perspective centres: names to numbers, lengths in metres."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.network import Distances, IntArray
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_groups import group_numbers, sigma_column
from splinebba_cli.project.build_images import ImageRows
from splinebba_cli.project.build_points import PointRows
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

DISTANCE_COLUMNS = Wanted(("from", "to", "length"), ("sigma_m", "use"))


def read_distances(
    building: Building, images: ImageRows, points: PointRows, renumbered: IntArray
) -> Distances:
    """All distances; `renumbered` maps points to those kept, -1 for those that no image determines."""
    parts, names = [], []
    for number, group in enumerate(building.model.observations.distances):
        path: YamlPath = ("observations", "distances", number)
        table = building.reader.read(group, path, DISTANCE_COLUMNS)
        if table is None:
            continue
        between_images = group.between == "images"
        known = {name: k for k, name in enumerate(images.ids)} if between_images else points.index()
        kept = np.arange(len(known)) if between_images else renumbered
        ends = [_numbers(table, column, known, kept, group.between, building) for column in ("from", "to")]
        length = table.numbers("length")
        _check(table, ends, building)
        sigma = sigma_column(group.sigma_m, table, "sigma_m", path, building)
        of_images = np.full((table.rows, 2), between_images)
        parts.append((np.stack(ends, axis=1), of_images, length, sigma, table.excluded()))
        names.append(group.name or group.table or f"distances[{number}]")
    if not parts:
        return Distances.none()
    station, is_image, length, sigma, out = (np.concatenate(column) for column in zip(*parts, strict=True))
    excluded = out if out.any() else None
    return Distances(station, is_image, length, sigma, group_numbers(parts), tuple(names), excluded)


def _numbers(
    table: Table, column: str, known: dict[str, int], kept: IntArray, kind: str, building: Building
) -> IntArray:
    """Numbers of the stations in a column; -1 (and an error) where there is none that is determined."""
    out = np.full(table.rows, -1, dtype=np.int64)
    for row, name in enumerate(table.texts(column)):
        place, one = table.place_of(row, column), kind[:-1]
        if name not in known:
            if one not in building.unread:
                building.unknown(one, name, place, known)
        elif kept[known[name]] < 0:
            message = f"{one} `{name}` of a distance is not measured in enough images"
            building.collector.error("SBB304", message, place, kind="points of distances without rays")
        else:
            out[row] = kept[known[name]]
    return out


def _check(table: Table, ends: list[IntArray], building: Building) -> None:
    """Lengths are positive and lead from one station to another."""
    for row in np.flatnonzero(table.numbers("length") <= 0.0)[:1]:
        building.collector.error("SBB205", "a distance must be positive", table.place_of(int(row), "length"))
    for row in np.flatnonzero((ends[0] == ends[1]) & (ends[0] >= 0))[:1]:
        building.collector.error(
            "SBB209", "a distance from a station to itself", table.place_of(int(row), "to")
        )
