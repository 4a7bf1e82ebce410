"""The kinds of observations that are simulated: for each, its noise-free values at the truth.

A further kind is one function here and one line in :data:`KINDS`.  Kinds that refer to measured curve points (by
their numbers in ``Network.curve_observations``) also name those fields, so that they follow when points are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import measured_photo_xy
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class ObservationKind:
    """One kind of observations of a network."""

    group: str  # attribute of Network that holds them
    value: str  # attribute of the group that holds the measured values
    exact: Callable[[Prepared, State], FloatArray]  # noise-free values, in the shape of `value`
    curve_points: tuple[str, ...] = ()  # attributes with numbers of measured curve points

    def of(self, network: Network) -> Any:
        """The group of this kind."""
        return getattr(network, self.group)


def exact_points(prepared: Prepared, state: State) -> FloatArray:
    """Noise-free photo coordinates of points, as measured, (n, 2) mm; NaN behind an image."""
    seen = prepared.network.point_observations
    return measured_xy(prepared, state, seen.image, state.xyz[seen.point])


def exact_curve_points(prepared: Prepared, state: State) -> FloatArray:
    """Noise-free photo coordinates of points on curves at their locations, as measured, (n, 2) mm."""
    seen = prepared.network.curve_observations
    xyz = prepared.curves.evaluate(state.coefficients, seen.curve, state.location)[0]
    return measured_xy(prepared, state, seen.image, xyz)


KINDS: tuple[ObservationKind, ...] = (
    ObservationKind("point_observations", "photo_xy", exact_points),
    ObservationKind("curve_observations", "photo_xy", exact_curve_points),
)


def measured_xy(prepared: Prepared, state: State, image: IntArray, xyz: FloatArray) -> FloatArray:
    """Photo coordinates of object points with principal point and distortion applied, (n, 2) mm."""
    network = prepared.network
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    camera = network.images.camera[image]
    for number, each in enumerate(network.cameras):
        rows = np.flatnonzero((camera == number) & np.isfinite(xy).all(axis=1))
        if len(rows):
            xy[rows] = measured_photo_xy(each, xy[rows])
    return xy


def with_values(network: Network, kind: ObservationKind, values: FloatArray) -> Network:
    """The network with other measured values of one kind."""
    changes: dict[str, Any] = {kind.group: replace(kind.of(network), **{kind.value: values})}
    return replace(network, **changes)


def select(group: Any, rows: IntArray) -> Any:
    """Some observations of a group: all its arrays that have one entry an observation."""
    count = len(group)
    arrays = {
        f.name: value[rows]
        for f in fields(group)
        if isinstance(value := getattr(group, f.name), np.ndarray) and len(value) == count
    }
    return replace(group, **arrays)
