"""Whether rows and options of a curve are those of its family, and whether its given values make a curve of it."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, Family, basis_of
from splinebba_cli.core.curves.shape_forms import form_values
from splinebba_cli.core.network import Curve

EXACT = 1e-6  # of the size of the curve: what fixed values may miss continuity or shape by
TURN = 2.0 * np.pi


class Report(Protocol):
    """Takes errors."""

    def __call__(self, code: str, message: str, key: str, help: str = "") -> None:
        """An error at a key of the spline."""


def check_family_rows(curve: Curve, error: Report) -> bool:
    """Number of rows, open or closed; False where the curve cannot be used."""
    family, rows, name = FAMILIES[curve.family], len(curve.values), f"spline `{curve.id}`"
    fewest = family.fewest_closed if curve.closed else family.fewest_open or family.fewest_closed
    if not fewest:
        closable = ", ".join(key for key, other in FAMILIES.items() if other.fewest_closed)
        error(
            "SBB209",
            f"{name}: a closed curve of family {curve.family}",
            "closed",
            f"{closable} can be closed",
        )
        return False
    if curve.family == "natural_cubic" and rows < fewest:
        kind = "a closed" if curve.closed else "an open"
        error("SBB307", f"{name}: {rows} knots, but {kind} natural spline needs {fewest}", "knots")
        return False
    wanted = _wanted_rows(curve, family, fewest)
    if wanted is None:
        return True
    error("SBB307" if rows < fewest else "SBB206", f"{name}: {rows} rows, but {wanted}", "knots")
    return False


def _wanted_rows(curve: Curve, family: Family, fewest: int) -> str | None:
    """What is wrong with the number of rows, in words; None where it is right."""
    rows = len(curve.values)
    if family.most is not None:
        return None if rows == family.most else f"{curve.family} has {family.most}"
    if family.rows == "powers" and rows % (family.degree + 1):
        return f"{curve.family} has {family.degree + 1} a segment"
    if family.rows == "harmonics" and (rows < fewest or rows % 2 == 0):
        return (
            f"{curve.family} has an odd number of rows from {fewest}: centre, cos u, sin u, cos 2u, sin 2u, …"
        )
    if rows < fewest:
        return f"{'a closed' if curve.closed else 'an open'} {curve.family} needs {fewest}"
    return None


def check_options(curve: Curve, error: Report) -> bool:
    """Continuity, natural ends, tension and knot parameters; False where the curve cannot be used."""
    found = [_continuity(curve), _natural_ends(curve), _tension(curve), _parameters(curve)]
    for problem in found:
        if problem is not None:
            code, message, key, help = problem
            error(code, f"spline `{curve.id}`: {message}", key, help)
    return not any(found)


Found = tuple[str, str, str, str] | None


def _continuity(curve: Curve) -> Found:
    family = FAMILIES[curve.family]
    if curve.continuity < 0:
        return None
    if family.rows != "powers":
        text = f"`continuity` in a curve of family {curve.family}"
        return "SBB209", text, "continuity", "it joins segments of polynomial_1, _2, _3 and free_cubic"
    if curve.continuity > family.degree - 1:
        text = f"segments of degree {family.degree} cannot be joined C{curve.continuity}"
        highest = "C-1" if family.degree == 0 else f"C{family.degree - 1}"
        return "SBB205", text, "continuity", f"at most {highest}"
    return None


def _natural_ends(curve: Curve) -> Found:
    family = FAMILIES[curve.family]
    if not curve.natural_ends:
        return None
    if family.rows != "powers" or family.degree != 3:
        return (
            "SBB209",
            f"`natural_ends` in a curve of family {curve.family}",
            "natural_ends",
            "they belong to free_cubic",
        )
    if curve.continuity != 2 and len(curve.values) > family.degree + 1:
        return "SBB209", "`natural_ends` without `continuity: C2`", "natural_ends", "write `continuity: C2`"
    return None


def _tension(curve: Curve) -> Found:
    if curve.tension == 0.0 or (curve.family == "cardinal" and -1.0 <= curve.tension < 1.0):
        return None
    if curve.family == "cardinal":
        return (
            "SBB205",
            f"tension {curve.tension:g} is not in [-1, 1)",
            "tension",
            "0 makes a Catmull-Rom spline",
        )
    return "SBB209", f"`tension` in a curve of family {curve.family}", "tension", "write `family: cardinal`"


def _parameters(curve: Curve) -> Found:
    parameters, family, key = curve.knot_parameters, FAMILIES[curve.family], "knot_parameters"
    if parameters is None:
        return None
    if not family.takes_parameters:
        return "SBB209", f"knot parameters in a curve of family {curve.family}", key, ""
    if family.rows == "harmonics" and curve.closed:
        return (
            "SBB209",
            "an arc is not closed",
            key,
            "remove `closed`, or `knot_parameters` for the whole curve",
        )
    expected = _parameter_count(curve, family)
    if len(parameters) != expected:
        return "SBB206", f"{len(parameters)} knot parameters, {expected} needed", key, ""
    steps = np.diff(parameters)
    if (steps <= 0.0).any():
        first = int(np.flatnonzero(steps <= 0.0)[0])
        return "SBB205", f"knot parameter {first + 1} is not larger than the one before", key, ""
    if family.rows == "harmonics" and steps[0] > TURN:
        return "SBB205", "an arc of more than a turn", key, "first and last u in radians, at most 2π apart"
    return None


def _parameter_count(curve: Curve, family: Family) -> int:
    if family.rows == "harmonics":
        return 2
    rows = len(curve.values)
    if family.rows == "powers":
        return rows // (family.degree + 1) + 1
    if curve.closed:
        return rows + 1
    return rows - family.degree + 1 if curve.family.startswith("bspline") else rows


def check_shape(curve: Curve, error: Report) -> None:
    """Known values must make a curve of the family: continuous where joined, a circle where it is one."""
    family, name = FAMILIES[curve.family], f"spline `{curve.id}`"
    if family.rows == "points":
        return
    basis = basis_of(curve)
    if family.rows == "harmonics":
        area = float(np.linalg.norm(np.cross(curve.values[1], curve.values[2])))
        if area <= EXACT * float(np.sum(curve.values[1:3] ** 2)):
            error(
                "SBB206",
                f"{name}: the vectors of cos u and sin u are parallel",
                "knots",
                "they span the curve's plane",
            )
            return
    if len(basis.shape_forms):
        held = curve.sigma[1:] == 0.0
        if held.any() and not held.all():
            help = "hold both vectors with all components, or none of them"
            error("SBB209", f"{name}: parts of the radius vectors of a circle are held", "held", help)
        elif held.all():
            off = np.abs(form_values(basis.shape_forms, curve.values)).max()
            if off > EXACT * float(np.sum(curve.values[1:] ** 2)):
                help = "their lengths must be equal, their scalar product 0; or write `family: conic`"
                error("SBB206", f"{name}: the fixed radius vectors are not those of a circle", "knots", help)
    elif basis.coefficient_count < len(curve.values) and (curve.sigma == 0.0).all():
        bound = basis.values_from_coefficients(basis.coefficients_from_values(curve.values))
        if np.abs(bound - curve.values).max() > EXACT * float(np.ptp(curve.values, axis=0).max()):
            ends = " with natural ends" if curve.natural_ends else ""
            message = f"{name}: the fixed segments are not joined C{curve.continuity}{ends}"
            error("SBB206", message, "knots", "give values that are, or a lower `continuity`")
