"""Splines and other linear features, in the user's frame."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from splinebba_cli.core.curves.given_shape import given_points
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.build_points import SIGMA_XYZ, XYZ, columns_of, sigma_columns
from splinebba_cli.project.curve_checks import check_curve
from splinebba_cli.project.diagnostics import Place, Places
from splinebba_cli.project.model_features import Spline, SplineTable
from splinebba_cli.project.model_tables import NumberTable
from splinebba_cli.project.table import Table
from splinebba_cli.project.table_reader import Wanted
from splinebba_cli.project.usual_curves import UsualRows
from splinebba_cli.project.yaml_source import YamlPath

REFERENCE_XYZ = tuple(f"reference_{axis}" for axis in XYZ)
_MANY = Wanted(("spline", *XYZ), (*SIGMA_XYZ, "sigma", "u", *REFERENCE_XYZ), {"id": "spline"})
_ROWS = Wanted(XYZ, (*SIGMA_XYZ, "sigma", "spline"), {"id": "spline"})
_DEFAULT = (*XYZ, *SIGMA_XYZ)


@dataclass
class CurveRows:
    """Curves of all entries, in the user's frame."""

    curves: list[Curve] = field(default_factory=list)
    places: Places = field(default_factory=Places)

    def index(self) -> dict[str, int]:
        """Index of each id."""
        return {curve.id: number for number, curve in enumerate(self.curves)}


def position_rows(curve: Curve) -> BoolArray:
    """Rows of `values` that are positions: all knots, but only power 0 of a polynomial and the centre of harmonics."""
    return FAMILIES[curve.family].positions(len(curve.values))


def shifted(curve: Curve, offset: FloatArray) -> Curve:
    """The curve moved by an offset, (3,) metres."""
    if not offset.any():
        return curve
    rows = position_rows(curve)[:, None]
    reference, check_values = curve.reference, curve.check_values
    return replace(
        curve,
        values=curve.values + rows * offset,
        reference=None if reference is None else reference + rows * offset,
        check_values=None if check_values is None else check_values + offset,
    )


def read_curves(building: Building) -> CurveRows:
    """All curves of the project, without duplicates, checked one by one."""
    rows = CurveRows()
    seen: dict[str, Callable[[], Place]] = {}
    for number, entry in enumerate(building.model.splines):
        path = building.source.resolve(("splines", number))
        if isinstance(entry, Spline):
            _add_spline(entry, path, rows, seen, building)
        else:
            _add_table(entry, path, rows, seen, building)
    return rows


def _add_table(
    entry: SplineTable,
    path: YamlPath,
    rows: CurveRows,
    seen: dict[str, Callable[[], Place]],
    building: Building,
) -> None:
    table = building.reader.read(entry, path, _MANY, ("spline", *XYZ))
    if table is None:
        building.unread.add("spline")
        return
    values = columns_of(table, XYZ, optional=False)
    sigma = sigma_columns(table, entry.sigma)
    by_id = building.reader.rows_by(table, "spline")
    parameters = table.numbers("u") if table.has("u") else None
    reference = columns_of(table, REFERENCE_XYZ, optional=False) if table.has("reference_x") else None
    usual = UsualRows.of(entry, values, sigma, parameters, list(by_id.values()))
    for number, (id, taken) in enumerate(by_id.items()):
        find = partial(table.place_of, int(taken[0]), "spline")
        own = taken if usual.scattered[number] else slice(int(taken[0]), int(taken[-1]) + 1)
        if id in seen or not usual.is_usual(number):
            spline = _entry(id, entry, None if parameters is None else parameters[own].tolist())
            held_to = None if reference is None else reference[own]
            usual.checked(
                number, _add(spline, values[own], sigma[own], held_to, find, None, rows, seen, building)
            )
            continue
        seen[id] = find
        rows.curves.append(
            Curve(
                id=id,
                role=entry.role,
                family=entry.family,
                values=values[own],
                sigma=usual.sigma[own],
                closed=entry.closed,
                knot_parameters=None if parameters is None else parameters[own],
                parameterization=entry.parameterization,
                reference=None if reference is None else reference[own],
                tension=entry.tension,
            )
        )
        rows.places.append(find)


def _entry(id: str, entry: SplineTable, parameters: list[float] | None) -> Spline:
    return Spline(
        id=id or "?",
        role=entry.role,
        family=entry.family,
        closed=entry.closed,
        parameterization=entry.parameterization,
        continuity=entry.continuity,
        natural_ends=entry.natural_ends,
        tension=entry.tension,
        knot_parameters=parameters,
    )


def _add_spline(
    entry: Spline, path: YamlPath, rows: CurveRows, seen: dict[str, Callable[[], Place]], building: Building
) -> None:
    place = building.source.place((*path, "id"))
    if entry.knots is None:
        help = "give approximate knots: `knots:` with rows x y z, or {table: file}"
        if entry.role in ("control", "partial"):
            building.collector.error("SBB308", f"{entry.role} spline `{entry.id}` has no knots", place, help)
        else:
            if building.purpose == "matching":
                help = f"{help}; or leave it out: `match --new-curves` builds splines from chains"
            building.collector.error("SBB312", f"spline `{entry.id}` has no approximate shape", place, help)
        return
    found = _rows(entry.id, entry.knots, (*path, "knots"), building)
    if found is None:
        return
    table, taken = found
    values = columns_of(table, XYZ, taken, optional=False)
    sigma = sigma_columns(table, entry.sigma, taken)
    reference = _further(entry, "reference_knots", path, building)
    _add(entry, values, sigma, reference, lambda: place, path, rows, seen, building)


def _rows(
    id: str, spec: NumberTable, path: YamlPath, building: Building
) -> tuple[Table, IntArray | slice] | None:
    """The table and the rows of one spline in it."""
    table = building.reader.read(spec, path, _ROWS, _DEFAULT)
    if table is None:
        return None
    if not table.has("spline"):
        if spec.table is not None:
            help = f"a table of one spline alone has no need of it; else add a column `spline` with `{id}`"
            building.collector.add(
                "info", "SBB402", f"`{spec.table}` has no column `spline`", building.source.place(path), help
            )
        return table, slice(None)
    by_id = building.reader.rows_by(table, "spline")
    if id not in by_id:
        building.unknown("spline", id, building.source.place(path), by_id)
        return None
    return table, by_id[id]


def _further(entry: Spline, name: str, path: YamlPath | None, building: Building) -> FloatArray | None:
    """Rows of reference_knots or check_values."""
    spec: NumberTable | None = getattr(entry, name)
    if spec is None or path is None:
        return None
    found = _rows(entry.id, spec, (*path, name), building)
    return None if found is None else columns_of(found[0], XYZ, found[1], optional=False)


def _add(
    entry: Spline,
    values: FloatArray,
    sigma: FloatArray,
    reference: FloatArray | None,
    find: Callable[[], Place],
    path: YamlPath | None,
    rows: CurveRows,
    seen: dict[str, Callable[[], Place]],
    building: Building,
) -> bool:
    """Check a curve and add it; whether it can be used."""
    if entry.id in seen:
        building.duplicate("spline", entry.id, find(), seen[entry.id]().line)
        return False
    seen[entry.id] = find
    sigma = _with_held(entry, sigma.copy(), path, building)
    check_values = _further(entry, "check_values", path, building)
    curve = Curve(
        id=entry.id,
        role=entry.role,
        family=entry.family,
        values=values,
        sigma=sigma,
        closed=entry.closed,
        knot_parameters=None if entry.knot_parameters is None else np.array(entry.knot_parameters),
        parameterization=entry.parameterization,
        breaks=tuple(sorted(entry.breaks)),
        reference=reference,
        continuity=int(entry.continuity[1:]),
        natural_ends=entry.natural_ends,
        tension=entry.tension,
        check_values=check_values,
        check_sigma=entry.check_sigma_m,
    )
    usable = check_curve(curve, find(), path, building)
    if usable:
        if entry.role == "check" and check_values is None:
            curve = replace(curve, check_values=given_points(curve))
        free = entry.role in ("tie", "partial", "check")
        curve = replace(curve, sigma=np.where(np.isnan(sigma), math.inf if free else 0.0, sigma))
        rows.curves.append(curve)
        rows.places.append(find)
    return usable


def _with_held(entry: Spline, sigma: FloatArray, path: YamlPath | None, building: Building) -> FloatArray:
    for number, held in enumerate(entry.held):
        if held.knot >= len(sigma):
            assert path is not None
            place = building.source.place((*path, "held", number, "knot"))
            message = f"spline `{entry.id}` has no knot {held.knot}"
            building.collector.error("SBB311", message, place, f"its knots are 0 … {len(sigma) - 1}")
        for component in held.components:
            sigma[min(held.knot, len(sigma) - 1), XYZ.index(component)] = 0.0
    return sigma
