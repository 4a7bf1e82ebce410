"""Arc lengths and tangents: references to measured curve points by their marks, lengths in mm, directions in rad."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import ArcLengths, BoolArray, FloatArray, IntArray, Tangents
from splinebba_cli.project.build_cameras import PhotoFrame
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_curves import CurveRows
from splinebba_cli.project.build_groups import group_numbers, sigma_column
from splinebba_cli.project.build_images import ANGLE_FACTORS, ImageRows
from splinebba_cli.project.build_observations import ObservationRows
from splinebba_cli.project.diagnostics import Place
from splinebba_cli.project.model_observations import ArcLengthGroup
from splinebba_cli.project.photo_directions import PIXELS, directions_in_photo, frames_of_rows
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

_UNITS = ("px", "um", "mm")
_SIGMAS = tuple(f"sigma_{unit}" for unit in _UNITS)
ARC_COLUMNS = Wanted(("image", "spline", "from", "to", "length"), (*_SIGMAS, "use"))
TANGENT_COLUMNS = Wanted(("image", "spline", "at", "direction"), ("sigma", "use"))

Key = tuple[str, str, str]  # image, spline, mark


@dataclass
class Marks:
    """Numbers of the measured curve points by image, spline and mark."""

    number: dict[Key, int]
    image: IntArray  # (n,)
    family: tuple[str, ...]  # (n,) of the curve of every measured point, empty where it could not be built
    building: Building

    @classmethod
    def of(cls, rows: ObservationRows, curves: CurveRows, building: Building) -> Marks:
        """Marks of all measured points; those without a column `mark` are counted for each image and spline."""
        number: dict[Key, int] = {}
        counted: dict[tuple[str, str], int] = {}
        row_number = 0
        for group in rows.groups:
            table = group.table
            images, splines = table.texts("image"), table.texts("spline")
            marks = table.texts("mark") if table.has("mark") else None
            for row, pair in enumerate(zip(images, splines, strict=True)):
                counted[pair] = counted.get(pair, 0) + 1
                mark = str(counted[pair]) if marks is None else marks[row]
                if (*pair, mark) in number:
                    where = f"mark `{mark}` of spline `{pair[1]}` in image `{pair[0]}`"
                    place = table.place_of(row, "mark" if marks is not None else "spline")
                    building.collector.error(
                        "SBB302", f"{where} given twice", place, kind="marks given twice"
                    )
                number[(*pair, mark)] = row_number
                row_number += 1
        families = [curve.family for curve in curves.curves]
        family = tuple(families[k] if k >= 0 else "" for k in rows.feature.tolist())
        return cls(number, rows.image, family, building)

    def image_of(self, point: IntArray) -> IntArray:
        """Image of measured points, (n,); -1 where there is none."""
        known = point >= 0
        out = np.full(len(point), -1, dtype=np.int64)
        out[known] = self.image[point[known]]
        return out

    def points(self, table: Table, column: str) -> IntArray:
        """Measured points that a column of marks names, (n,); -1 (and an error) where there is none."""
        columns = (table.texts("image"), table.texts("spline"), table.texts(column))
        out = np.full(table.rows, -1, dtype=np.int64)
        for row, key in enumerate(zip(*columns, strict=True)):
            found = self.number.get(key)
            if found is None:
                message = f"spline `{key[1]}` has no measured point `{key[2]}` in image `{key[0]}`"
                help = "marks are in column `mark` of spline_points; without it points count from 1"
                self.building.collector.error(
                    "SBB301", message, table.place_of(row, column), help, kind="unknown marks"
                )
            else:
                out[row] = found
        return out


def read_arc_lengths(
    building: Building, images: ImageRows, marks: Marks, frames: list[PhotoFrame], renumbered: IntArray
) -> ArcLengths:
    """All arc lengths; `renumbered` maps measured points to those kept, -1 for those left out."""
    parts, names, tables = [], [], []
    for number, group in enumerate(building.model.observations.arc_lengths):
        path: YamlPath = ("observations", "arc_lengths", number)
        table = building.reader.read(group, path, ARC_COLUMNS)
        if table is None:
            continue
        first, second = marks.points(table, "from"), marks.points(table, "to")
        image = marks.image_of(first)
        factor = _mm_per_unit(group, image, images, frames, path, building)
        length = table.numbers("length") * factor
        _check_positive(table, length, building)
        sigma = _length_sigma(group, table, image, images, frames, path, building)
        parts.append((first, second, length, sigma, np.full(table.rows, group.method == "simpson")))
        tables.append(table)
        names.append(group.name or group.table or f"arc_lengths[{number}]")
    if not parts:
        return ArcLengths.none()
    first, second, length, sigma, simpson = (np.concatenate(column) for column in zip(*parts, strict=True))
    _check_links(tables, first, second, building)
    kept = (first >= 0) & (second >= 0)
    kept[kept] = renumbered[first[kept]] >= 0
    return ArcLengths(
        renumbered[first[kept]], renumbered[second[kept]], length[kept], sigma[kept], simpson[kept],
        group_numbers(parts)[kept], tuple(names), _excluded(tables, kept),
    )  # fmt: skip


def read_tangents(
    building: Building, images: ImageRows, marks: Marks, frames: list[PhotoFrame], renumbered: IntArray
) -> Tangents:
    """All tangents; parameters as for arc lengths."""
    parts, names, tables = [], [], []
    for number, group in enumerate(building.model.observations.tangents):
        path: YamlPath = ("observations", "tangents", number)
        table = building.reader.read(group, path, TANGENT_COLUMNS)
        if table is None:
            continue
        unit = group.angle_unit or building.model.project.angle_unit
        if unit is None:
            help = "angle_unit: deg, gon or rad, here or in `project`"
            building.collector.error("SBB202", "directions without a unit", building.source.place(path), help)
            unit = "deg"
        point = marks.points(table, "at")
        direction = table.numbers("direction") * ANGLE_FACTORS[unit]
        sigma = sigma_column(group.sigma, table, "sigma", path, building) * ANGLE_FACTORS[unit]
        turned = directions_in_photo(direction, group, marks.image_of(point), images, frames)
        parts.append((point, turned, sigma, np.full(table.rows, group.directed)))
        tables.append(table)
        names.append(group.name or group.table or f"tangents[{number}]")
    if not parts:
        return Tangents.none()
    point, direction, sigma, directed = (np.concatenate(column) for column in zip(*parts, strict=True))
    _check_once(tables, point, "at", "two tangents at one measured point", building)
    for row in np.flatnonzero([k >= 0 and marks.family[k] == "polynomial_0" for k in point.tolist()])[:1]:
        building.collector.error(
            "SBB209", "a tangent at a curve that is a point", _place(tables, int(row), "at")
        )
    kept = point >= 0
    kept[kept] = renumbered[point[kept]] >= 0
    return Tangents(
        renumbered[point[kept]], direction[kept], sigma[kept], directed[kept], group_numbers(parts)[kept],
        tuple(names), _excluded(tables, kept),
    )  # fmt: skip


def _excluded(tables: Sequence[Table], kept: BoolArray) -> BoolArray | None:
    """Which of the kept rows of all tables the user has taken out; None where none is."""
    found = np.concatenate([table.excluded() for table in tables])[kept]
    return found if found.any() else None


def _place(tables: Sequence[Table], row: int, column: str) -> Place:
    """Where a row of all tables under each other stands."""
    for table in tables:
        if row < table.rows:
            return table.place_of(row, column)
        row -= table.rows
    raise IndexError(row)


def _check_links(tables: Sequence[Table], first: IntArray, second: IntArray, building: Building) -> None:
    """A chain runs from point to point, through all groups: no forks, no rings, no arc from a point to itself."""
    for row in np.flatnonzero((first == second) & (first >= 0))[:1]:
        message = "an arc length from a measured point to itself"
        building.collector.error("SBB209", message, _place(tables, int(row), "to"))
    _check_once(tables, first, "from", "two arc lengths begin at one measured point", building)
    _check_once(tables, second, "to", "two arc lengths end at one measured point", building)
    links = [(a, b) for a, b in zip(first.tolist(), second.tolist(), strict=True) if a >= 0 and a != b]
    following = dict(links)
    for start in set(following) - {b for _, b in links}:
        while start in following:
            start = following.pop(start)
    if following and len({a for a, _ in links}) == len(links) == len({b for _, b in links}):
        help = "leave one of them out: the last one says nothing new"
        building.collector.error("SBB209", "arc lengths close a ring", _place(tables, 0, "from"), help)


def _check_once(
    tables: Sequence[Table], point: IntArray, column: str, message: str, building: Building
) -> None:
    known = np.flatnonzero(point >= 0)
    _, first_row = np.unique(point[known], return_index=True)
    for row in np.setdiff1d(known, known[first_row])[:1]:
        building.collector.error("SBB302", message, _place(tables, int(row), column))


def _check_positive(table: Table, length: FloatArray, building: Building) -> None:
    for row in np.flatnonzero(length <= 0.0)[:1]:
        building.collector.error(
            "SBB205", "an arc length must be positive", table.place_of(int(row), "length")
        )


def _mm_per_unit(
    group: ArcLengthGroup, image: IntArray, images: ImageRows, frames: list[PhotoFrame], path: YamlPath,
    building: Building,
) -> FloatArray:  # fmt: skip
    """Millimetres per unit of the lengths, (n,)."""
    out = np.ones(len(image))
    for rows, frame, wanted in frames_of_rows(group, image, images, frames):
        if wanted == "photo_um":
            out[rows] = 1e-3
        elif wanted in PIXELS:
            out[rows] = _square_pixel(frame, path, building)
    return out


def _square_pixel(frame: PhotoFrame, path: YamlPath, building: Building) -> float:
    """Size of a pixel, mm; an error where it is unknown or not square."""
    place = building.source.place(path)
    if frame.pixel_size_mm is None:
        building.collector.error("SBB202", "lengths in pixels, but the camera has no `pixel_size_mm`", place)
        return 1.0
    width, height = frame.pixel_size_mm
    if abs(width - height) > 1e-9 * width:
        help = "give them in mm or µm: `image_coordinates: photo_mm`"
        building.collector.error("SBB209", "lengths in pixels that are not square", place, help)
    return float(width)


def _length_sigma(
    group: ArcLengthGroup, table: Table, image: IntArray, images: ImageRows, frames: list[PhotoFrame],
    path: YamlPath, building: Building,
) -> FloatArray:  # fmt: skip
    """σ of the lengths, (n,) mm."""
    units = {name for name in _SIGMAS if getattr(group, name) is not None or table.has(name)}
    place = building.source.place(path)
    help = "one of sigma_px, sigma_um, sigma_mm, for the group or as a column"
    if len(units) != 1:
        code, what = ("SBB202", "no σ for the arc lengths") if not units else ("SBB209", "σ in two units")
        building.collector.error(code, what, place, help)
        return np.ones(table.rows)
    name = units.pop()
    sigma = sigma_column(getattr(group, name), table, name, path, building)
    if name == "sigma_px":
        for rows, frame, _ in frames_of_rows(group, image, images, frames):
            sigma[rows] *= _square_pixel(frame, path, building)
        return sigma
    return sigma * (1e-3 if name == "sigma_um" else 1.0)
