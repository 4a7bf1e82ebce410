"""Arc lengths between measured curve points and tangents at them, added to a simulated network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import ArcLengths, FloatArray, IntArray, Network, Tangents
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.observation_kinds import exact_arc_lengths, exact_tangents
from splinebba_cli.simulation.truth import Truth, true_state


def consecutive_points(network: Network, location: FloatArray) -> IntArray:
    """Pairs (q, 2) of measured points that follow each other along one curve in one image."""
    observed = network.curve_observations
    order = np.lexsort((location, observed.curve, observed.image))
    same = (np.diff(observed.image[order]) == 0) & (np.diff(observed.curve[order]) == 0)
    return np.stack([order[:-1][same], order[1:][same]], axis=1)


def with_arc_lengths(
    network: Network,
    truth: Truth,
    sigma_mm: float,
    generator: np.random.Generator | None,
    *,
    simpson: bool = False,
) -> Network:
    """The network with an arc length between all consecutive points.

    Parameters
    ----------
    sigma_mm : stated, and of the noise
    generator : None leaves the lengths exact
    simpson : rule by which they will be adjusted; the lengths themselves are true ones
    """
    pairs = consecutive_points(network, truth.locations)
    count = len(pairs)
    arcs = ArcLengths(
        pairs[:, 0], pairs[:, 1], np.ones(count), np.full(count, sigma_mm), np.full(count, simpson)
    )
    network = replace(network, arc_lengths=arcs)
    prepared = prepare(network)
    length = exact_arc_lengths(prepared, true_state(prepared, truth))
    noise = 0.0 if generator is None else sigma_mm * generator.standard_normal(count)
    return replace(network, arc_lengths=replace(arcs, length=length + noise))


def with_tangents(
    network: Network,
    truth: Truth,
    sigma_rad: float,
    generator: np.random.Generator | None,
    *,
    directed: bool = False,
) -> Network:
    """The network with the direction of the curve at every measured point; parameters as for arc lengths."""
    prepared = prepare(network)
    point = np.flatnonzero(prepared.curves.has_location[network.curve_observations.curve])
    count = len(point)
    tangents = Tangents(point, np.zeros(count), np.full(count, sigma_rad), np.full(count, directed))
    network = replace(network, tangents=tangents)
    prepared = prepare(network)
    direction = exact_tangents(prepared, true_state(prepared, truth))
    noise = 0.0 if generator is None else sigma_rad * generator.standard_normal(count)
    return replace(network, tangents=replace(tangents, direction=direction + noise))
