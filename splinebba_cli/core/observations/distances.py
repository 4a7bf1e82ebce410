"""Distances in the object between points or perspective centres: scale bars and bases.

    r = (|X_2 - X_1| - l) / sigma,    dr/dX_2 = -dr/dX_1 = (X_2 - X_1)' / (|X_2 - X_1| sigma)

They fix the scale of a network without control.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import Distances, FloatArray
from splinebba_cli.core.state import State


@dataclass(frozen=True)
class DistanceRows:
    """Linearised equations of distances, one a row."""

    residual: FloatArray  # (q,) whitened
    jacobian: FloatArray  # (q, 2, 3) d/d position of either end
    cost: float


def linearize_distances(distances: Distances, state: State) -> DistanceRows:
    """Equations of all distances at the current state.

    Raises
    ------
    FloatingPointError
        If both ends of a distance are at the same place.
    """
    ends = np.empty((len(distances), 2, 3))
    ends[distances.is_image] = state.position[distances.station[distances.is_image]]
    ends[~distances.is_image] = state.xyz[distances.station[~distances.is_image]]
    between = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(between, axis=1)
    if not (length > 0.0).all():
        raise FloatingPointError("the ends of a distance are at the same place")
    direction = between / (length * distances.sigma)[:, None]
    residual = (length - distances.length) / distances.sigma
    return DistanceRows(residual, np.stack([-direction, direction], axis=1), float(residual @ residual))
