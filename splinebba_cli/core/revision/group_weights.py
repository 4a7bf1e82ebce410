"""The sigma of whole groups of observations multiplied by a factor each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from splinebba_cli.core.evidence import VarianceComponent
from splinebba_cli.core.network import FloatArray, Network
from splinebba_cli.core.quality.observation_groups import ObservationGroup, observation_groups

TABLES = {
    "point": "point_observations",
    "spline": "curve_observations",
    "arc length": "arc_lengths",
    "tangent": "tangents",
    "distance": "distances",
}


def with_factors(network: Network, factors: Sequence[float] | FloatArray) -> Network:
    """The network with the sigma of its groups multiplied; factors in the order of observation_groups, (G,)."""
    for group, factor in zip(observation_groups(network), factors, strict=True):
        if factor != 1.0:
            network = _scaled(network, group, float(factor))
    return network


def with_given_sigma(network: Network, components: tuple[VarianceComponent, ...]) -> Network:
    """An adjusted network with the sigma of its groups as they were given, before their factors.

    A group of which nothing took part has no component and keeps its sigma.
    """
    factor = {(each.kind, each.group): each.factor for each in components}
    groups = observation_groups(network)
    return with_factors(network, [1.0 / factor.get((group.kind, group.name), 1.0) for group in groups])


def _scaled(network: Network, group: ObservationGroup, factor: float) -> Network:
    if group.kind in TABLES:
        table = getattr(network, TABLES[group.kind])
        changed = replace(table, sigma=_times(table.sigma, group, factor))
        return replace(network, **{TABLES[group.kind]: changed})
    if group.kind == "control point":
        return replace(
            network, points=replace(network.points, sigma=_flat(network.points.sigma, group, factor))
        )
    if group.kind == "eop prior":
        sigma = _flat(network.images.prior_sigma, group, factor)
        return replace(network, images=replace(network.images, prior_sigma=sigma))
    curves = tuple(
        replace(curve, sigma=np.where(np.isfinite(curve.sigma), factor * curve.sigma, curve.sigma))
        for curve in network.curves
    )
    return replace(network, curves=curves)


def _times(sigma: FloatArray, group: ObservationGroup, factor: float) -> FloatArray:
    out = sigma.copy()
    out[group.rows] *= factor
    return out


def _flat(sigma: FloatArray, group: ObservationGroup, factor: float) -> FloatArray:
    out = sigma.copy()
    out.reshape(-1)[group.rows] *= factor
    return out
