"""Whether the values of one curve make sense: number of rows, σ, parameters, corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import Curve
from splinebba_cli.project.build_context import Building
from splinebba_cli.project.diagnostics import Place
from splinebba_cli.project.family_checks import check_family_rows, check_options, check_shape
from splinebba_cli.project.yaml_source import YamlPath


@dataclass(frozen=True)
class _Where:
    place: Place
    path: YamlPath | None
    building: Building

    def of(self, key: str) -> Place:
        """Place of a key of the spline, else of the spline."""
        if self.path is None or (*self.path, key) not in self.building.source.keys:
            return self.place
        return self.building.source.place((*self.path, key), key=True)

    def error(self, code: str, message: str, key: str, help: str = "") -> None:
        self.building.collector.error(code, message, self.of(key), help, kind=f"splines: {key}")


def check_curve(curve: Curve, place: Place, path: YamlPath | None, building: Building) -> bool:
    """Report what is wrong with a curve; False where it cannot be used at all."""
    where = _Where(place, path, building)
    shape_ok = _check_rows(curve, where)
    _check_sigma(curve, where)
    if not shape_ok:
        return False
    shape_ok = check_options(curve, where.error)
    _check_breaks(curve, where)
    _check_reference(curve, where)
    if curve.check_values is not None and curve.role != "check":
        where.error(
            "SBB209", f"{curve.role} spline `{curve.id}` has `check_values`", "check_values", "role: check"
        )
    if shape_ok:
        check_shape(curve, where.error)
    return shape_ok


def _check_rows(curve: Curve, where: _Where) -> bool:
    if np.isnan(curve.values).any():
        return False  # reported with the table
    return check_family_rows(curve, where.error) and _check_distances(curve, where)


def _check_distances(curve: Curve, where: _Where) -> bool:
    if FAMILIES[curve.family].rows != "points":
        return True
    knots = np.vstack([curve.values, curve.values[:1]]) if curve.closed else curve.values
    steps = np.diff(knots, axis=0)
    same = np.flatnonzero(np.linalg.norm(steps, axis=1) == 0.0)
    if not len(same):
        return True
    if curve.closed and same[0] == len(steps) - 1:
        message = f"spline `{curve.id}` is closed and repeats its first knot at the end"
        where.error("SBB206", message, "knots", "leave the last knot out")
        return False
    message = f"spline `{curve.id}`: knots {same[0]} and {same[0] + 1} are the same"
    where.error("SBB206", message, "knots", "leave one of them out")
    return False


def _check_sigma(curve: Curve, where: _Where) -> None:
    given = np.isfinite(curve.sigma)
    name = f"{curve.role} spline `{curve.id}`"
    if curve.role == "control" and np.isnan(curve.sigma).any():
        where.error("SBB202", f"{name} has no σ", "sigma", "sigma: a number in metres, or `fixed`")
    elif curve.role == "control" and np.isposinf(curve.sigma).any():
        where.error("SBB209", f"{name} has free coefficients", "sigma", "write `role: partial`")
    elif curve.role == "partial" and not given.any():
        where.error("SBB308", f"{name} has no known coefficient", "held", "give `held` or σ of some knots")
    elif curve.role in ("tie", "check") and given.any():
        key = "held" if (curve.sigma == 0.0).any() else "sigma"
        where.error(
            "SBB209", f"{name} has known coefficients", key, "write `role: partial` or `role: control`"
        )


def _check_breaks(curve: Curve, where: _Where) -> None:
    first, last = (0, len(curve.values) - 1) if curve.closed else (1, len(curve.values) - 2)
    wrong = [number for number in curve.breaks if not first <= number <= last]
    if curve.breaks and curve.family != "natural_cubic":
        where.error("SBB209", f"spline `{curve.id}`: corners in a curve of family {curve.family}", "breaks")
    elif wrong:
        help = f"inner knots are {first} … {last}" if last >= first else "it has no inner knot"
        where.error("SBB311", f"spline `{curve.id}` has no inner knot {wrong[0]}", "breaks", help)
    elif len(set(curve.breaks)) != len(curve.breaks):
        where.error("SBB209", f"spline `{curve.id}`: a corner is given twice", "breaks")


def _check_reference(curve: Curve, where: _Where) -> None:
    if curve.reference is not None and curve.reference.shape != curve.values.shape:
        message = f"spline `{curve.id}`: {len(curve.reference)} reference knots for {len(curve.values)} knots"
        where.error("SBB206", message, "reference_knots")
