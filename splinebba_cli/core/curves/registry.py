"""Curve families by name.  To add one: write its file, add its line here."""

from __future__ import annotations

from collections.abc import Callable

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.natural_cubic import natural_cubic
from splinebba_cli.core.curves.polynomial import polynomial_0, polynomial_1, polynomial_2, polynomial_3
from splinebba_cli.core.curves.straight_line import straight_line
from splinebba_cli.core.network import Curve

FAMILIES: dict[str, Callable[[Curve], CurveBasis]] = {
    "natural_cubic": natural_cubic,
    "straight_line": straight_line,
    "polynomial_0": polynomial_0,
    "polynomial_1": polynomial_1,
    "polynomial_2": polynomial_2,
    "polynomial_3": polynomial_3,
    "free_cubic": polynomial_3,
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
    basis = FAMILIES[curve.family](curve)
    if len(curve.values) != basis.coefficient_count:
        raise ValueError(
            f"a curve of family {curve.family} needs {basis.coefficient_count} rows, not {len(curve.values)}"
        )
    return basis
