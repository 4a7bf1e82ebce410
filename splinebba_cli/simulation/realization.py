"""One realization of a design: measurements with noise, given values with errors, wrong starts.

Every source of errors has its own stream of the seed, so that changing one does not change the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from splinebba_cli.core.network import Curve, FloatArray, Images, Network, Points
from splinebba_cli.core.state import prepare
from splinebba_cli.simulation.dropping import Dropped, drop_measurements
from splinebba_cli.simulation.noise import Noise, observed, perturbed
from splinebba_cli.simulation.observation_kinds import KINDS, with_values
from splinebba_cli.simulation.truth import Truth, rotations_of, true_state


@dataclass(frozen=True)
class Design:
    """What is measured, what is known and how well; all measurements free of noise.

    The approximate values of ``network`` are those that a project has by itself; given values are replaced by true
    ones with errors in every realization.
    """

    network: Network
    truth: Truth


@dataclass(frozen=True)
class Streams:
    """Independent generators of one seed."""

    noise: np.random.Generator
    start: np.random.Generator
    given: np.random.Generator
    blunder: np.random.Generator
    missing: np.random.Generator

    @classmethod
    def of(cls, seed: int) -> Streams:
        """The streams of a seed."""
        return cls(*(np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(5)))


def realize(design: Design, noise: Noise, seed: int) -> Dropped:
    """A network to adjust, with its truth, for one seed.

    Parameters
    ----------
    noise : sizes of all errors
    seed : the same design, noise and seed give the same network

    Returns
    -------
    Dropped
        Network and truth of what is left after measurements were dropped, and where it stands in the design.
    """
    streams, truth = Streams.of(seed), design.truth
    given = streams.given if noise.draws_given_values else None
    network = design.network
    network = replace(
        network,
        images=_images(network.images, truth, noise, streams.start, given),
        points=_points(network.points, truth, noise, given),
        curves=tuple(
            _curve(curve, values, noise, streams.start, given)
            for curve, values in zip(network.curves, truth.curves, strict=True)
        ),
    )
    network = _measured(network, noise, streams)
    return drop_measurements(
        network, truth, noise.missing_point_share, noise.missing_pair_share, streams.missing
    )


def exact_network(network: Network, truth: Truth) -> Network:
    """The network with noise-free measurements of all kinds at the truth; locations unknown."""
    for kind in KINDS:
        if len(kind.of(network)):
            prepared = prepare(
                network
            )  # lengths and directions are carried through the lens at the measured points
            network = with_values(network, kind, kind.exact(prepared, true_state(prepared, truth)))
    unknown = np.full(len(network.curve_observations), np.nan)
    return replace(network, curve_observations=replace(network.curve_observations, location=unknown))


def _measured(network: Network, noise: Noise, streams: Streams) -> Network:
    """Noise on the measured values of all kinds, then blunders."""
    for kind in KINDS:
        group = kind.of(network)
        if not len(group):
            continue
        exact: FloatArray = getattr(group, kind.value)
        own = (
            noise.image_mm == 0.0 or kind.value == "photo_xy"
        )  # without noise in the photo everything is exact
        size = noise.image_mm if own and noise.image_mm is not None else group.sigma
        values = exact + size * streams.noise.standard_normal(exact.shape)
        if noise.blunder_share > 0.0:
            values = values + _blunders(group, exact, noise, streams.blunder)
        network = with_values(network, kind, np.asarray(values))
    return network


def _blunders(group: Any, exact: FloatArray, noise: Noise, generator: np.random.Generator) -> FloatArray:
    """Gross errors of round(share n) measurements, of one size in σ and of any direction."""
    count = len(exact)
    hit = generator.choice(count, round(noise.blunder_share * count), replace=False)
    direction = generator.standard_normal((len(hit), *exact.shape[1:]))
    flat = direction.reshape(len(hit), -1)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    out = np.zeros_like(exact)
    out[hit] = noise.blunder_size * group.sigma[hit] * flat.reshape(direction.shape)
    return out


def _images(
    images: Images, truth: Truth, noise: Noise, start: np.random.Generator, given: np.random.Generator | None
) -> Images:
    """Priors with errors; starts that are wrong, or as the project has them; fixed unknowns at the truth."""
    angles, position = truth.eop[:, :3], truth.eop[:, 3:]
    rotation, fixed = images.rotation, images.prior_sigma == 0.0
    if noise.start_angle_rad is not None:
        rotation = rotations_of(perturbed(angles, noise.start_angle_rad, start), images.sequence)
    held = fixed[:, :3].all(axis=1)
    rotation = np.where(held[:, None, None], truth.rotation, rotation)
    start_position = images.position
    if noise.start_position_m is not None:
        start_position = perturbed(position, noise.start_position_m, start)
    known = np.isfinite(images.prior_sigma)
    prior = images.prior
    if known.any():
        prior = np.where(known, observed(truth.eop, images.prior_sigma, given), np.nan)
    return replace(
        images,
        rotation=rotation,
        position=np.where(fixed[:, 3:], position, start_position),
        prior=prior,
    )


def _points(points: Points, truth: Truth, noise: Noise, given: np.random.Generator | None) -> Points:
    """Given coordinates with errors; tie points as the project has them, or unknown where orientations are wrong."""
    check = np.array([role == "check" for role in points.role], dtype=bool)[:, None]
    sigma = np.where(check, points.check_sigma, points.sigma)
    known = np.isfinite(sigma)
    own = np.full_like(points.xyz, np.nan) if noise.perturbs_orientations else points.xyz
    return replace(points, xyz=np.where(known, observed(truth.points, sigma, given), own))


def _curve(
    curve: Curve,
    true: FloatArray,
    noise: Noise,
    start: np.random.Generator,
    given: np.random.Generator | None,
) -> Curve:
    """The curve as people know it: known values with their errors, wrong starts elsewhere."""
    known = observed(true, curve.sigma, given)
    own = curve.values if noise.start_knots_m is None else perturbed(true, noise.start_knots_m, start)
    return replace(curve, values=np.where(np.isfinite(curve.sigma), known, own))
