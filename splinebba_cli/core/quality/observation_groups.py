"""Groups of observations of one precision: those that the project names, control and priors by their kind.

Entries of one kind with the same name are one group.

Gauge, shape and datum conditions are no group, nor are held values that became equations of very large weight.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.evidence import ObservationKind
from splinebba_cli.core.network import (
    ArcLengths,
    CurveObservations,
    Distances,
    FloatArray,
    IntArray,
    Network,
    PointObservations,
    Tangents,
)

KIND_NAMES: dict[ObservationKind, str] = {
    "point": "points",
    "spline": "splines",
    "arc length": "arc lengths",
    "tangent": "tangents",
    "distance": "distances",
}
Measured = PointObservations | CurveObservations | ArcLengths | Tangents | Distances
ANGLES, POSITIONS = "prior angles", "prior positions"


@dataclass(frozen=True)
class ObservationGroup:
    """Rows of one group among the observations of their kind."""

    name: str
    kind: ObservationKind
    rows: IntArray  # (n,) observations; of control and priors (item * components + component) in the given tables


def observation_groups(network: Network) -> tuple[ObservationGroup, ...]:
    """All groups that have observations."""
    measured: list[tuple[ObservationKind, Measured]] = [
        ("point", network.point_observations),
        ("spline", network.curve_observations),
        ("arc length", network.arc_lengths),
        ("tangent", network.tangents),
        ("distance", network.distances),
    ]
    found = [group for kind, table in measured for group in _named(kind, table)]
    found.append(ObservationGroup("control points", "control point", _weighted(network.points.sigma)))
    values = np.concatenate([np.zeros((0, 3)), *(curve.sigma for curve in network.curves)])
    found.append(ObservationGroup("control splines", "control spline", _weighted(values)))
    prior = _weighted(network.images.prior_sigma)
    found.append(ObservationGroup(ANGLES, "eop prior", prior[prior % 6 < 3]))
    found.append(ObservationGroup(POSITIONS, "eop prior", prior[prior % 6 >= 3]))
    return tuple(group for group in found if len(group.rows))


def _named(kind: ObservationKind, table: Measured) -> list[ObservationGroup]:
    if table.group is None:
        return [ObservationGroup(KIND_NAMES[kind], kind, np.arange(len(table)))]
    numbers: dict[str, list[int]] = {}
    for number, name in enumerate(table.group_names):
        numbers.setdefault(name, []).append(number)
    return [
        ObservationGroup(name, kind, np.flatnonzero(np.isin(table.group, own)))
        for name, own in numbers.items()
    ]


def _weighted(sigma: FloatArray) -> IntArray:
    return np.flatnonzero(np.isfinite(sigma) & (sigma > 0.0))
