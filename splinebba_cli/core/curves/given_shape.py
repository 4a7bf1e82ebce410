"""Points along the given shape of a curve, whatever the rows of its values are."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES, basis_of
from splinebba_cli.core.network import Curve, FloatArray

PER_SEGMENT = 8


def given_points(curve: Curve) -> FloatArray:
    """Points (q, 3) on the curve of the given values: its knots, or samples where rows are no points of it.

    Raises
    ------
    ValueError
        If the values make no curve of the family.
    """
    if FAMILIES[curve.family].rows == "points" and not curve.family.startswith("bspline"):
        return curve.values.copy()
    basis = basis_of(curve)
    if not basis.has_location:
        return curve.values.copy()
    breaks = basis.break_points
    share = np.arange(PER_SEGMENT) / PER_SEGMENT
    u = (breaks[:-1, None] + share * np.diff(breaks)[:, None]).ravel()
    u = u if basis.closed else np.append(u, breaks[-1])
    return basis.evaluate(u, basis.coefficients_from_values(curve.values))
