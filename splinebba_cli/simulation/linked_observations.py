"""Arc lengths between measured curve points and tangents at them, added to a simulated network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.distortion import measured_photo_xy
from splinebba_cli.core.network import ArcLengths, FloatArray, IntArray, Network, Tangents
from splinebba_cli.core.observations.arc_lengths import arc_lengths_at
from splinebba_cli.core.observations.tangents import linearize_tangents
from splinebba_cli.core.state import State, initial_coefficients, prepare
from splinebba_cli.simulation.truth import Truth, at_truth


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
    exact = ArcLengths(
        pairs[:, 0], pairs[:, 1], np.ones(count), np.full(count, sigma_mm), np.zeros(count, dtype=bool)
    )
    bare = at_truth(replace(network, arc_lengths=exact, tangents=Tangents.none()), truth)
    prepared = prepare(bare)
    scale = prepared.arc_lengths.value  # of lengths of 1 mm: what the correction of the lens makes of them
    length = arc_lengths_at(prepared, _state(bare), np.arange(count)) / scale
    noise = 0.0 if generator is None else sigma_mm * generator.standard_normal(count)
    return replace(
        network, arc_lengths=replace(exact, length=length + noise, simpson=np.full(count, simpson))
    )


def with_tangents(
    network: Network,
    truth: Truth,
    sigma_rad: float,
    generator: np.random.Generator | None,
    *,
    directed: bool = False,
) -> Network:
    """The network with the direction of the curve at every measured point; parameters as for arc lengths."""
    curved = np.array([curve.family != "polynomial_0" for curve in network.curves], dtype=bool)
    point = np.flatnonzero(curved[network.curve_observations.curve])
    count = len(point)
    blank = Tangents(point, np.zeros(count), np.full(count, 1.0), np.ones(count, dtype=bool))
    bare = at_truth(replace(network, tangents=blank, arc_lengths=ArcLengths.none()), truth)
    prepared = prepare(bare)
    rows = linearize_tangents(prepared, _state(bare))
    corrected = rows.residual * prepared.tangents.sigma + prepared.tangents.value
    noise = 0.0 if generator is None else sigma_rad * generator.standard_normal(count)
    direction = _measured_directions(bare, corrected) + noise
    return replace(
        network,
        tangents=Tangents(point, direction, np.full(count, sigma_rad), np.full(count, directed)),
    )


def _measured_directions(network: Network, corrected: FloatArray) -> FloatArray:
    """Directions in the measured frame of directions in the corrected one, at the tangents' points."""
    observed, step = network.curve_observations, 1e-4
    out = np.empty(len(corrected))
    camera_of = network.images.camera[observed.image[network.tangents.point]]
    rays = prepare(network).curve_rays.xy[network.tangents.point]
    ahead = step * np.stack([np.cos(corrected), np.sin(corrected)], axis=1)
    for number, camera in enumerate(network.cameras):
        rows = camera_of == number
        moved = measured_photo_xy(camera, rays[rows] + ahead[rows]) - measured_photo_xy(
            camera, rays[rows] - ahead[rows]
        )
        out[rows] = np.arctan2(moved[:, 1], moved[:, 0])
    return out


def _state(network: Network) -> State:
    """The approximate values of a network as a state."""
    images = network.images
    return State(
        rotation=images.rotation,
        position=images.position,
        coefficients=initial_coefficients(prepare(network)),
        xyz=network.points.xyz,
        location=network.curve_observations.location,
    )
