"""The network that the loop adjusts: all priors as measurements, without what has no approximate value."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.approximation.control_network import known_curves
from splinebba_cli.core.approximation.orientation import approximate_orientations
from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.matching.known_curves.orientation_prior import OrientationPrior, with_prior
from splinebba_cli.core.network import (
    ArcLengths,
    BoolArray,
    Distances,
    FloatArray,
    Network,
    Tangents,
    select_rows,
)
from splinebba_cli.core.observations.coefficient_rows import knot_distance
from splinebba_cli.core.state import Prepared, State, initial_coefficients

ROUGH_SHAPE = 0.1  # of the knot distance: sigma of an approximate shape


@dataclass(frozen=True)
class Start:
    """Network and state with which the loop begins."""

    network: Network
    state: State
    prior: OrientationPrior
    known: BoolArray  # (nc,) curves whose shape is given with standard deviations
    held: BoolArray  # (nc,) of these, curves that are not adjusted at all
    shaped: BoolArray  # (nc,) curves that have a shape at all
    shape_sigma: FloatArray  # (nc,) metres

    def with_prior(self, prior: OrientationPrior) -> Start:
        """With other standard deviations of assumed priors."""
        return replace(self, network=with_prior(self.network, prior, ~prior.known), prior=prior)


def loop_start(network: Network, prepared: Prepared, prior: OrientationPrior) -> Start:
    """Network and state of the loop.

    Points without a position and images without an orientation take no part, nor do measurements of them.
    """
    known = np.array([bool(np.isfinite(curve.sigma).all()) for curve in network.curves], dtype=bool)
    shaped = np.array([bool(np.isfinite(curve.values).all()) for curve in network.curves], dtype=bool)
    lost = ~prior.known
    rotation = np.where(lost[:, None, None], np.eye(3), prior.rotation)
    position = np.where(lost[:, None], 0.0, prior.position)
    within = _without_lost(network, prior.known)
    xyz = approximate_orientations(within).xyz
    within, xyz = _with_located_points(within, xyz)
    state = State(rotation, position, initial_coefficients(prepared), xyz, within.curve_observations.location)
    return Start(
        network=with_prior(within, prior, lost),
        state=state,
        prior=prior,
        known=known & shaped,
        held=known_curves(network),
        shaped=shaped,
        shape_sigma=shape_sigmas(network),
    )


def shape_sigmas(network: Network) -> FloatArray:
    """How far the given shape of curves may be off, (nc,) metres: as stated, else a share of the knot distance."""
    found = np.zeros(len(network.curves))
    for number, curve in enumerate(network.curves):
        position = FAMILIES[curve.family].positions(len(curve.values))
        stated = curve.sigma[position]
        if np.isfinite(curve.sigma).all():
            found[number] = float(np.sqrt(np.mean(stated**2)))
        elif np.isfinite(curve.values).all():
            found[number] = ROUGH_SHAPE * knot_distance(curve)
    return found


def _without_lost(network: Network, oriented: BoolArray) -> Network:
    """The network without measurements in images that have no orientation."""
    if oriented.all():
        return network
    points, curves = network.point_observations, network.curve_observations
    both = (
        network.distances.is_image
        & ~oriented[np.where(network.distances.is_image, network.distances.station, 0)]
    )
    return replace(
        network,
        point_observations=select_rows(points, np.flatnonzero(oriented[points.image])),
        curve_observations=select_rows(curves, np.flatnonzero(oriented[curves.image])),
        arc_lengths=ArcLengths.none(),
        tangents=Tangents.none(),
        distances=select_rows(network.distances, np.flatnonzero(~both.any(axis=1))),
    )


def _with_located_points(network: Network, xyz: FloatArray) -> tuple[Network, FloatArray]:
    """The network with points that have a position only, and the positions."""
    good: BoolArray = np.asarray(np.isfinite(xyz).all(axis=1))
    observed = network.point_observations
    good &= np.bincount(observed.point, minlength=len(good)) > 0
    if good.all():
        return network, xyz
    number = np.cumsum(good) - 1
    points = network.points
    kept = np.flatnonzero(good)
    rows = select_rows(observed, np.flatnonzero(good[observed.point]))
    distances = network.distances
    lost = ~distances.is_image & ~good[np.where(distances.is_image, 0, distances.station)]
    left: Distances = select_rows(distances, np.flatnonzero(~lost.any(axis=1)))
    station = np.where(left.is_image, left.station, number[np.where(left.is_image, 0, left.station)])
    within = replace(
        network,
        points=replace(
            points,
            ids=tuple(points.ids[k] for k in kept),
            role=tuple(points.role[k] for k in kept),
            xyz=xyz[kept],
            sigma=points.sigma[kept],
            check_sigma=points.check_sigma[kept],
        ),
        point_observations=replace(rows, point=number[rows.point]),
        distances=replace(left, station=station),
    )
    return within, xyz[kept]
