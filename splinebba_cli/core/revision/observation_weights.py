"""Factors of the weights of measurements: sigma becomes sigma / sqrt(p), and p = 0 takes a measurement out.

Two forms.  While outliers are sought, all measurements stay and p = 0 is a weight of 1e-10: such a row pulls the
solution by 1e-10 of what it did, and the same equations give its residual and its leverage against the others.  For the
solution that is reported, rows of p = 0 are left out, and so are their locations, so that all counts are right.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray, Network, Points, select_rows
from splinebba_cli.core.revision.observation_list import (
    ARCS,
    CURVES,
    DISTANCES,
    KINDS,
    POINTS,
    TANGENTS,
    ObservationList,
)
from splinebba_cli.core.state import ImageRays, Prepared, State

FAINT = (
    1e-10  # weight of a measurement that is out while outliers are sought: an error of 1000 sigma pulls 1e-7
)


def faintly_weighted(prepared: Prepared, listed: ObservationList, factor: FloatArray) -> Prepared:
    """A prepared network (of factors 1) with the factors (N,); 0 becomes :data:`FAINT`."""
    network = prepared.network
    scale = 1.0 / np.sqrt(np.maximum(factor, FAINT))
    points, curves = listed.part(scale, POINTS), listed.part(scale, CURVES)
    arcs, tangents = listed.part(scale, ARCS), listed.part(scale, TANGENTS)
    distances = listed.part(scale, DISTANCES)
    return replace(
        prepared,
        network=replace(
            network,
            point_observations=replace(
                network.point_observations, sigma=network.point_observations.sigma * points[:, None]
            ),
            curve_observations=replace(
                network.curve_observations, sigma=network.curve_observations.sigma * curves[:, None]
            ),
            arc_lengths=replace(network.arc_lengths, sigma=network.arc_lengths.sigma * arcs),
            tangents=replace(network.tangents, sigma=network.tangents.sigma * tangents),
            distances=replace(network.distances, sigma=network.distances.sigma * distances),
        ),
        point_rays=_scaled(prepared.point_rays, points),
        curve_rays=_scaled(prepared.curve_rays, curves),
        arc_lengths=replace(prepared.arc_lengths, sigma=prepared.arc_lengths.sigma * arcs),
        tangents=replace(prepared.tangents, sigma=prepared.tangents.sigma * tangents),
    )


def _scaled(rays: ImageRays, scale: FloatArray) -> ImageRays:
    return ImageRays(rays.xy, rays.whitening / scale[:, None, None])


@dataclass(frozen=True)
class Reduced:
    """A network without the measurements that are out, and which rows of each kind it has kept."""

    network: Network
    points: IntArray
    curves: IntArray
    arcs: IntArray
    tangents: IntArray
    distances: IntArray

    @property
    def rows(self) -> tuple[IntArray, ...]:
        """Kept rows in the order of the kinds."""
        return self.points, self.curves, self.arcs, self.tangents, self.distances

    def state(self, state: State) -> State:
        """A state of all measurements, its locations cut to those that are left."""
        return replace(state, location=state.location[self.curves])


def reduced(listed: ObservationList, factor: FloatArray, xyz: FloatArray | None = None) -> Reduced:
    """The network of a list with its factors (N,) applied.

    Parameters
    ----------
    factor : with the arcs, tangents and rays that nothing holds any more already 0
        (:meth:`ObservationList.orphans`, :meth:`ObservationList.unlocated`)
    xyz : (n, 3) places at which object points that have lost their rays are held; None: nothing has lost them
    """
    network = listed.network
    rows = [np.flatnonzero(listed.part(factor, kind) > 0.0) for kind in range(len(KINDS))]
    scale = [1.0 / np.sqrt(listed.part(factor, kind)[rows[kind]]) for kind in range(len(KINDS))]
    number = np.full(len(network.curve_observations), -1)
    number[rows[CURVES]] = np.arange(len(rows[CURVES]))
    points = select_rows(network.point_observations, rows[POINTS])
    curves = select_rows(network.curve_observations, rows[CURVES])
    arcs = select_rows(network.arc_lengths, rows[ARCS])
    tangents = select_rows(network.tangents, rows[TANGENTS])
    distances = select_rows(network.distances, rows[DISTANCES])
    made = replace(
        network,
        points=network.points if xyz is None else _with_held_points(listed, factor, xyz),
        point_observations=replace(points, sigma=points.sigma * scale[POINTS][:, None], excluded=None),
        curve_observations=replace(curves, sigma=curves.sigma * scale[CURVES][:, None], excluded=None),
        arc_lengths=replace(
            arcs,
            first=number[arcs.first],
            second=number[arcs.second],
            sigma=arcs.sigma * scale[ARCS],
            excluded=None,
        ),
        tangents=replace(
            tangents, point=number[tangents.point], sigma=tangents.sigma * scale[TANGENTS], excluded=None
        ),
        distances=replace(distances, sigma=distances.sigma * scale[DISTANCES], excluded=None),
    )
    return Reduced(made, *rows)


def lost_points(listed: ObservationList, factor: FloatArray) -> IntArray:
    """Object points with a free coordinate that no measurement locates any more."""
    network = listed.network
    seen = network.point_observations.point
    count = len(network.points.ids)
    before = np.bincount(seen, minlength=count)
    after = np.bincount(seen, listed.part(factor, POINTS) > 0.0, minlength=count)
    free = np.isinf(network.points.sigma).any(axis=1)
    return np.flatnonzero(free & (before > 0) & (after == 0))


def _with_held_points(listed: ObservationList, factor: FloatArray, xyz: FloatArray) -> Points:
    points, lost = listed.network.points, lost_points(listed, factor)
    sigma, place = points.sigma.copy(), points.xyz.copy()
    sigma[lost], place[lost] = 0.0, xyz[lost]
    return replace(points, xyz=place, sigma=sigma)
