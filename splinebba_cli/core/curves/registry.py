"""Curve families by name.  To add one: write its file, add its line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.bspline import bspline_1, bspline_2, bspline_3
from splinebba_cli.core.curves.cardinal import cardinal, catmull_rom
from splinebba_cli.core.curves.conic import circle, conic
from splinebba_cli.core.curves.fourier import fourier
from splinebba_cli.core.curves.natural_cubic import natural_cubic
from splinebba_cli.core.curves.polynomial import polynomial_0, polynomial_1, polynomial_2, polynomial_3
from splinebba_cli.core.curves.straight_line import straight_line
from splinebba_cli.core.network import BoolArray, Curve, FloatArray

# sigma of gauge conditions in knot distances: knots that a curve passes through slide along it, and corners need that
# freedom; where a whole curve or segment can be parametrised anew, weak conditions would let it slide far along bends
WEAK, TIGHT = 0.1, 1e-3


@dataclass(frozen=True)
class Family:
    """How curves of a family are made, and what the rows of their values are."""

    basis: Callable[[Curve], CurveBasis]
    rows: Literal["points", "powers", "harmonics"]
    degree: int = 3  # powers: a row for each power 0 .. degree of every segment
    fewest_open: int = 1  # rows; 0: never open
    fewest_closed: int = 0  # rows; 0: never closed
    most: int | None = None  # rows; None: any number
    takes_parameters: bool = True  # whether knot parameters may be given
    keeps_parameters: bool = True  # whether they stay when values change
    gauge_fraction: float = TIGHT  # sigma of gauge conditions in knot distances

    def positions(self, rows: int) -> BoolArray:
        """Which rows of the values are positions and move with the frame (the others are vectors), (rows,)."""
        step = {"points": 1, "powers": self.degree + 1, "harmonics": rows}[self.rows]
        return np.asarray(np.arange(rows) % step == 0)


FAMILIES: dict[str, Family] = {
    "natural_cubic": Family(natural_cubic, "points", fewest_open=2, fewest_closed=3, gauge_fraction=WEAK),
    "straight_line": Family(
        straight_line,
        "points",
        1,
        2,
        0,
        2,
        takes_parameters=False,
        keeps_parameters=False,
        gauge_fraction=WEAK,
    ),
    "polynomial_0": Family(
        polynomial_0, "powers", 0, 1, 0, 1, takes_parameters=False, keeps_parameters=False
    ),
    "polynomial_1": Family(polynomial_1, "powers", 1, 2, keeps_parameters=False),
    "polynomial_2": Family(polynomial_2, "powers", 2, 3, keeps_parameters=False),
    "polynomial_3": Family(polynomial_3, "powers", 3, 4, keeps_parameters=False),
    "free_cubic": Family(polynomial_3, "powers", 3, 4, keeps_parameters=False),
    "cardinal": Family(cardinal, "points", fewest_open=2, fewest_closed=3, gauge_fraction=WEAK),
    "catmull_rom": Family(catmull_rom, "points", fewest_open=2, fewest_closed=3, gauge_fraction=WEAK),
    "bspline_1": Family(bspline_1, "points", 1, 2, 3),
    "bspline_2": Family(bspline_2, "points", 2, 3, 3),
    "bspline_3": Family(bspline_3, "points", 3, 4, 3),
    "fourier": Family(fourier, "harmonics", 0, 0, 3, takes_parameters=False, keeps_parameters=False),
    "conic": Family(conic, "harmonics", 0, 3, 3, 3, keeps_parameters=False),
    "circle": Family(circle, "harmonics", 0, 3, 3, 3, keeps_parameters=False),
}


def basis_of(curve: Curve) -> CurveBasis:
    """The basis of a curve.

    Raises
    ------
    KeyError
        If the family is not registered.
    ValueError
        If the values do not make a curve of the family.
    """
    basis = FAMILIES[curve.family].basis(curve)
    if len(curve.values) != len(basis.value_columns):
        raise ValueError(
            f"a curve of family {curve.family} needs {len(basis.value_columns)} rows, not {len(curve.values)}"
        )
    return basis


def lasting_parameters(curve: Curve, basis: CurveBasis) -> FloatArray | None:
    """Knot parameters of a curve that stay when its values change; None where the family has none of its own."""
    return basis.break_points.copy() if FAMILIES[curve.family].keeps_parameters else curve.knot_parameters
