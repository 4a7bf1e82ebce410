"""Cofactors of the locations of all measured curve points.

A point that nothing links to others has, with the equation along the curve a p + |b| u,

    Q_uu = (1 + a Q a') / |b|^2.

Like every figure along a curve it depends on the gauge.  A location that is held has none.
"""

from __future__ import annotations

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.linked_cofactors import LinkedCofactors


def location_cofactors(cofactors: Cofactors, linked: LinkedCofactors) -> FloatArray:
    """Q_uu of every measured point, (n,); 0 where the location is held."""
    return linked.location + cofactors.curve.location
