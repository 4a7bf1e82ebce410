"""From a true scene to a design, and to a network with noise and wrong starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import (
    BoolArray,
    Camera,
    Curve,
    FloatArray,
    Images,
    Network,
    Points,
    RotationSequence,
)
from splinebba_cli.simulation.block_geometry import BlockGeometry
from splinebba_cli.simulation.feature_geometry import Feature, PointFeatures, samples
from splinebba_cli.simulation.measuring import measure_curves, measure_points
from splinebba_cli.simulation.noise import Noise
from splinebba_cli.simulation.realization import Design, realize
from splinebba_cli.simulation.truth import Truth, rotations_of

NOMINAL_SIGMA_MM = 0.005  # stated for exact measurements
CHECK_SAMPLES = 60
PLACES_SEED = 19  # the places of measurement belong to the design, not to the noise


def assemble(
    block: BlockGeometry,
    features: tuple[Feature, ...],
    points: PointFeatures,
    points_per_curve: int,
    eop_sigma: FloatArray | None,
    noise: Noise,
    seed: int,
) -> tuple[Network, Truth]:
    """Network and truth of a scene.

    Parameters
    ----------
    points_per_curve : measured points for every curve and image that sees it
    eop_sigma : (6,) standard deviations of observed exterior orientations (rad, m), None where there are none
    seed : of noise and starts; separate streams, so that starts do not change the noise
    """
    sigma = noise.image_mm or NOMINAL_SIGMA_MM
    made = realize(scene_design(block, features, points, points_per_curve, eop_sigma, sigma), noise, seed)
    return made.network, made.truth


def scene_design(
    block: BlockGeometry,
    features: tuple[Feature, ...],
    points: PointFeatures,
    points_per_curve: int,
    eop_sigma: FloatArray | None,
    sigma_mm: float,
) -> Design:
    """The design of a scene; `sigma_mm` is stated for all measured coordinates, its starts are the truth."""
    curves = tuple(_curve(feature) for feature in features)
    shapes = [feature.shape() for feature in features]
    places = np.random.default_rng(PLACES_SEED)
    curve_seen, locations = measure_curves(block, shapes, points_per_curve, places)
    locations = np.where(_approximates(features)[curve_seen.curve], np.nan, locations)
    points = _seen_twice(block, points)
    point_seen = measure_points(block, points.xyz)
    network = Network(
        origin=block.origin,
        cameras=(_camera(block),),
        images=_images(block, eop_sigma),
        points=_points(points),
        curves=curves,
        point_observations=replace(point_seen, sigma=np.full_like(point_seen.photo_xy, sigma_mm)),
        curve_observations=replace(curve_seen, sigma=np.full_like(curve_seen.photo_xy, sigma_mm)),
    )
    return Design(network, Truth(block.eop, tuple(f.values for f in features), points.xyz, locations))


def _approximates(features: tuple[Feature, ...]) -> BoolArray:
    """Whether the adjusted curve is not the true one, so that places on that are none on this, (curves,)."""
    return np.array([feature.really is not None for feature in features], dtype=bool)


def _seen_twice(block: BlockGeometry, points: PointFeatures) -> PointFeatures:
    """The points that at least two images see."""
    rays = np.bincount(measure_points(block, points.xyz).point, minlength=len(points.ids))
    keep = np.flatnonzero(rays >= 2)
    return PointFeatures(
        tuple(points.ids[i] for i in keep),
        tuple(points.role[i] for i in keep),
        points.xyz[keep],
        points.sigma[keep],
    )


def _camera(block: BlockGeometry) -> Camera:
    return Camera(
        id="camera",
        principal_distance_mm=block.principal_distance_mm,
        principal_point_mm=np.zeros(2),
        radial=np.zeros(3),
        decentring=np.zeros(2),
        affinity=np.zeros(2),
        pixel_size_mm=block.pixel_size_mm,
        format_mm=block.format_mm,
    )


def _images(block: BlockGeometry, eop_sigma: FloatArray | None) -> Images:
    count = len(block.eop)
    prior, prior_sigma = np.full((count, 6), np.nan), np.full((count, 6), np.inf)
    if eop_sigma is not None:
        prior, prior_sigma = block.eop.copy(), np.tile(eop_sigma, (count, 1))
    sequence: RotationSequence = "omega-phi-kappa"
    return Images(
        ids=tuple(str(i + 1) for i in range(count)),
        camera=np.zeros(count, dtype=np.int64),
        rotation=rotations_of(block.eop[:, :3], ()),
        position=block.eop[:, 3:].copy(),
        sequence=(sequence,) * count,
        prior=prior,
        prior_sigma=prior_sigma,
    )


def _points(points: PointFeatures) -> Points:
    """Control and check points with their given coordinates; tie points without."""
    role = np.array(points.role, dtype="<U7")[:, None]
    return Points(
        ids=points.ids,
        role=points.role,
        xyz=np.where(role == "tie", np.nan, points.xyz),
        sigma=np.where(role == "control", points.sigma, np.inf),
        check_sigma=np.where(role == "check", points.sigma, np.nan),
    )


def _curve(feature: Feature) -> Curve:
    """The true curve; given points of check splines lie on it."""
    curve = feature.curve(feature.values)
    if feature.role == "check":
        curve = replace(curve, check_values=samples(feature, CHECK_SAMPLES))
    return curve if feature.role == "control" else replace(curve, reference=feature.values)
