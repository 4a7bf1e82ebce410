"""The kinds of observations that are simulated: for each, its noise-free values at the truth.

A further kind is one function here and one line in :data:`KINDS`.  Kinds that refer to measured curve points (by
their numbers in ``Network.curve_observations``) also name those fields, so that they follow when points are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.distortion import measured_photo_xy
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.network import select_rows as select
from splinebba_cli.core.observations.arc_lengths import arc_lengths_at
from splinebba_cli.core.observations.distances import linearize_distances
from splinebba_cli.core.observations.tangents import linearize_tangents
from splinebba_cli.core.state import Prepared, State

__all__ = ["KINDS", "ObservationKind", "measured_xy", "select", "with_lens", "with_values"]

DIRECTION_STEP_MM = 1e-4  # to either side, for directions through the lens


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


def exact_arc_lengths(prepared: Prepared, state: State) -> FloatArray:
    """True lengths of all arcs in the measured frame, whatever the rule of their adjustment, (q,) mm."""
    network = prepared.network
    every = np.arange(len(network.arc_lengths))
    exact = replace(network.arc_lengths, simpson=np.zeros(len(every), dtype=bool))
    prepared = replace(prepared, network=replace(network, arc_lengths=exact))
    return arc_lengths_at(prepared, state, every) / prepared.arc_lengths.rate


def exact_tangents(prepared: Prepared, state: State) -> FloatArray:
    """True directions at all tangents in the measured frame, (q,) rad; in the sense of ascending locations."""
    network = prepared.network
    directed = replace(network.tangents, directed=np.ones(len(network.tangents), dtype=bool))
    prepared = replace(prepared, network=replace(network, tangents=directed))
    rows = linearize_tangents(prepared, state)
    corrected = rows.residual * prepared.tangents.sigma + prepared.tangents.value
    point = network.tangents.point
    xyz = prepared.curves.evaluate(
        state.coefficients, network.curve_observations.curve[point], state.location[point]
    )[0]
    image = network.curve_observations.image[point]
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    ahead = DIRECTION_STEP_MM * np.stack([np.cos(corrected), np.sin(corrected)], axis=1)
    moved = with_lens(network, image, xy + ahead) - with_lens(network, image, xy - ahead)
    return np.asarray(np.arctan2(moved[:, 1], moved[:, 0]))


def exact_distances(prepared: Prepared, state: State) -> FloatArray:
    """True lengths between stations, (q,) m."""
    given = prepared.network.distances
    return linearize_distances(given, state).residual * given.sigma + given.length


KINDS: tuple[ObservationKind, ...] = (
    ObservationKind("point_observations", "photo_xy", exact_points),
    ObservationKind("curve_observations", "photo_xy", exact_curve_points),
    ObservationKind("arc_lengths", "length", exact_arc_lengths, ("first", "second")),
    ObservationKind("tangents", "direction", exact_tangents, ("point",)),
    ObservationKind("distances", "length", exact_distances),
)


def measured_xy(prepared: Prepared, state: State, image: IntArray, xyz: FloatArray) -> FloatArray:
    """Photo coordinates of object points with principal point and distortion applied, (n, 2) mm."""
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    return with_lens(prepared.network, image, xy)


def with_lens(network: Network, image: IntArray, corrected: FloatArray) -> FloatArray:
    """Photo coordinates as measured, of those in the corrected frame, (n, 2) mm."""
    xy, camera = corrected.copy(), network.images.camera[image]
    for number, each in enumerate(network.cameras):
        rows = np.flatnonzero((camera == number) & np.isfinite(xy).all(axis=1))
        if len(rows):
            xy[rows] = measured_photo_xy(each, xy[rows])
    return xy


def with_values(network: Network, kind: ObservationKind, values: FloatArray) -> Network:
    """The network with other measured values of one kind."""
    changes: dict[str, Any] = {kind.group: replace(kind.of(network), **{kind.value: values})}
    return replace(network, **changes)
