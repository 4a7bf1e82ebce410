"""Points of the object, in the user's frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import get_args

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.diagnostics import Place, Places, suggestion
from splinebba_cli.project.model_features import Point, PointTable
from splinebba_cli.project.scalars import PointRole
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.yaml_source import YamlPath

XYZ = ("x", "y", "z")
SIGMA_XYZ = ("sigma_x", "sigma_y", "sigma_z")
ROLES: tuple[PointRole, ...] = get_args(PointRole)
_TABLE = Wanted(("point",), (*XYZ, *SIGMA_XYZ, "sigma", "role"), {"id": "point"})


@dataclass
class PointRows:
    """Points of all entries; NaN where a coordinate or σ is not given."""

    ids: list[str] = field(default_factory=list)
    roles: list[PointRole] = field(default_factory=list)
    xyz: list[FloatArray] = field(default_factory=list)  # (3,) user frame
    sigma: list[FloatArray] = field(default_factory=list)  # (3,) as given
    places: Places = field(default_factory=Places)
    unusable: set[str] = field(default_factory=set)  # ids of points with an error

    def index(self) -> dict[str, int]:
        """Index of each id."""
        return {id: number for number, id in enumerate(self.ids)}

    def declared(self) -> dict[str, int]:
        """Index of each id; one that could not be used is -2, so that it is no unknown id."""
        return {**dict.fromkeys(self.unusable, -2), **self.index()}


def read_points(building: Building) -> PointRows:
    """All points of the project, without duplicates, checked one by one."""
    rows = PointRows()
    seen: dict[str, int] = {}
    for number, entry in enumerate(building.model.points):
        path = building.source.resolve(("points", number))
        if isinstance(entry, Point):
            xyz = np.array(entry.xyz if entry.xyz is not None else [math.nan] * 3)
            sigma = np.array(entry.sigma if entry.sigma is not None else [math.nan] * 3)
            _add(
                entry.id,
                entry.role,
                xyz,
                sigma,
                partial(building.source.place, (*path, "id")),
                rows,
                seen,
                building,
            )
        else:
            _add_table(entry, path, rows, seen, building)
    return rows


def _add_table(
    entry: PointTable, path: YamlPath, rows: PointRows, seen: dict[str, int], building: Building
) -> None:
    table = building.reader.read(entry, path, _TABLE, ("point", *XYZ))
    if table is None:
        building.unread.add("point")
        return
    ids = table.texts("point")
    taken = _selected(entry, path, ids, building)
    xyz = columns_of(table, XYZ)
    roles = _roles(entry, path, table, building)
    sigma = sigma_columns(table, entry.sigma)
    if table.has("role"):  # σ of the whole table is that of its points with coordinates
        ties = np.array([role == "tie" for role in roles], dtype=bool)
        sigma[ties] = sigma_columns(table, None)[ties]
    for row in taken:
        role = roles[row]
        if role is None:
            rows.unusable.add(ids[row])
        elif ids[row]:
            find = partial(table.place_of, row, "point")
            _add(ids[row], role, xyz[row], sigma[row], find, rows, seen, building)


def _selected(entry: PointTable, path: YamlPath, ids: list[str], building: Building) -> list[int]:
    """Rows of the points to take."""
    have = set(ids)
    for key, names in (("only", entry.only or []), ("except", entry.except_)):
        for number, name in enumerate(names):
            if name not in have:
                place = building.source.place((*path, key, number))
                building.unknown("point", name, place, have)
    only = None if entry.only is None else set(entry.only)
    without = set(entry.except_)
    return [row for row, id in enumerate(ids) if (only is None or id in only) and id not in without]


ALL_ROWS = slice(None)


def columns_of(
    table: Table, names: Sequence[str], rows: IntArray | slice = ALL_ROWS, *, optional: bool = True
) -> FloatArray:
    """Columns of numbers, (n, len(names)); NaN where absent, or empty if that is allowed."""
    out = np.full((_row_count(table, rows), len(names)), np.nan)
    for number, name in enumerate(names):
        if table.has(name):
            out[:, number] = table.numbers(name, optional=optional)[rows]
    return out


def sigma_columns(
    table: Table, default: tuple[float, float, float] | None, rows: IntArray | slice = ALL_ROWS
) -> FloatArray:
    """σ of x, y, z, (n, 3): of the columns sigma_x …, else sigma, else the default, else NaN."""
    out = np.full((_row_count(table, rows), 3), np.nan)
    if table.has("sigma"):
        out[:] = table.sigmas("sigma")[rows, None]
    for number, name in enumerate(SIGMA_XYZ):
        if table.has(name):
            values = table.sigmas(name)[rows]
            out[:, number] = np.where(np.isnan(values), out[:, number], values)
    return out if default is None else np.where(np.isnan(out), np.array(default), out)


def _row_count(table: Table, rows: IntArray | slice) -> int:
    return table.rows if isinstance(rows, slice) else len(rows)


def _roles(entry: PointTable, path: YamlPath, table: Table, building: Building) -> list[PointRole | None]:
    if not table.has("role"):
        if entry.role is None:
            help = "role: control, tie or check, or a column `role`"
            place = building.source.place(path)
            building.collector.error("SBB202", f"no role for the points of `{table.file}`", place, help)
        return [entry.role] * table.rows
    roles: list[PointRole | None] = []
    for row, name in enumerate(table.columns["role"]):
        name = str(name).strip()
        role = entry.role if not name else next((r for r in ROLES if r == name), None)
        if role is None:
            help = suggestion(name, ROLES) or "control, tie or check"
            place = table.place_of(row, "role")
            building.collector.error("SBB204", f"role `{name}` is not known", place, help, kind="roles")
        roles.append(role)
    return roles


def _add(
    id: str,
    role: PointRole,
    xyz: FloatArray,
    sigma: FloatArray,
    find: Callable[[], Place],
    rows: PointRows,
    seen: dict[str, int],
    building: Building,
) -> None:
    if id in seen:
        building.duplicate("point", id, find(), rows.places[seen[id]].line)
        return
    seen[id] = len(rows.ids)
    _check(id, role, xyz, sigma, find, building)
    rows.ids.append(id)
    rows.roles.append(role)
    rows.xyz.append(xyz)
    rows.sigma.append(sigma)
    rows.places.append(find)


def _check(
    id: str,
    role: PointRole,
    xyz: FloatArray,
    sigma: FloatArray,
    find: Callable[[], Place],
    building: Building,
) -> None:
    error = building.collector.error
    lacking = ", ".join(name for name, value in zip(XYZ, xyz, strict=True) if np.isnan(value))
    if role == "control":
        if np.isnan(sigma).any():
            help = "sigma: a number in metres, or `fixed`"
            error("SBB202", f"control point `{id}` has no σ", find(), help, kind="control points without σ")
        needed = ~np.isposinf(sigma)
        if (needed & np.isnan(xyz)).any():
            help = "give x, y and z, or `free` as σ of a coordinate that is unknown"
            error(
                "SBB308",
                f"control point `{id}` has no {lacking}",
                find(),
                help,
                kind="control without coordinates",
            )
        elif np.isposinf(sigma).all():
            error("SBB209", f"control point `{id}` is free in all coordinates", find(), "write `role: tie`")
    elif role == "check" and lacking:
        error(
            "SBB308", f"check point `{id}` has no {lacking}", find(), kind="check points without coordinates"
        )
    elif role == "tie" and np.isfinite(sigma).any():
        help = "write `role: control` for a point with known coordinates"
        error("SBB209", f"tie point `{id}` has a σ", find(), help, kind="tie points with σ")
