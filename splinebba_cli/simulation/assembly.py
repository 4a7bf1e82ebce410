"""From a true scene to a network: measurements with noise, given values, wrong starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.rotation import rotation_object_from_photo
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
from splinebba_cli.simulation.noise import Noise, measure_curves, measure_points, perturbed
from splinebba_cli.simulation.truth import Truth

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
    noise_stream, start_stream, given_stream = (
        np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(3)
    )
    shapes = [feature.shape() for feature in features]
    places = np.random.default_rng(PLACES_SEED)
    curve_seen, locations = measure_curves(block, shapes, points_per_curve, places)
    locations = np.where(_approximates(features)[curve_seen.curve], np.nan, locations)
    points = _seen_twice(block, points)
    point_seen = measure_points(block, points.xyz)
    sigma = noise.image_mm or NOMINAL_SIGMA_MM

    def measured(exact: FloatArray) -> FloatArray:
        return np.asarray(exact + noise.image_mm * noise_stream.standard_normal(exact.shape))

    given = given_stream if noise.image_mm > 0.0 else None
    network = Network(
        origin=block.origin,
        cameras=(_camera(block),),
        images=_images(block, eop_sigma, noise, start_stream, given),
        points=_points(points, given),
        curves=tuple(_given_curve(f, noise.start_knots_m, start_stream, given) for f in features),
        point_observations=replace(
            point_seen,
            photo_xy=measured(point_seen.photo_xy),
            sigma=np.full_like(point_seen.photo_xy, sigma),
        ),
        curve_observations=replace(
            curve_seen,
            photo_xy=measured(curve_seen.photo_xy),
            sigma=np.full_like(curve_seen.photo_xy, sigma),
        ),
    )
    return network, Truth(block.eop, tuple(f.values for f in features), points.xyz, locations)


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
        format_mm=block.format_mm,
    )


def _images(
    block: BlockGeometry,
    eop_sigma: FloatArray | None,
    noise: Noise,
    start: np.random.Generator,
    given: np.random.Generator | None,
) -> Images:
    count = len(block.eop)
    angles = perturbed(block.eop[:, :3], noise.start_angle_rad, start)
    position = perturbed(block.eop[:, 3:], noise.start_position_m, start)
    prior, prior_sigma = np.full((count, 6), np.nan), np.full((count, 6), np.inf)
    if eop_sigma is not None:
        prior_sigma = np.tile(eop_sigma, (count, 1))
        prior = _observed(block.eop, prior_sigma, given)
    sequence: RotationSequence = "omega-phi-kappa"
    return Images(
        ids=tuple(str(i + 1) for i in range(count)),
        camera=np.zeros(count, dtype=np.int64),
        rotation=rotation_object_from_photo(angles),
        position=position,
        sequence=(sequence,) * count,
        prior=prior,
        prior_sigma=prior_sigma,
    )


def _observed(true: FloatArray, sigma: FloatArray, given: np.random.Generator | None) -> FloatArray:
    """True values with errors of the given standard deviations (0, inf: none); exact without a generator."""
    if given is None:
        return true.copy()
    size = np.where(np.isfinite(sigma), sigma, 0.0)
    return np.asarray(true + size * given.standard_normal(true.shape))


def _points(points: PointFeatures, given: np.random.Generator | None) -> Points:
    """Control and check points with their given coordinates; tie points without."""
    role = np.array(points.role, dtype="<U7")[:, None]
    return Points(
        ids=points.ids,
        role=points.role,
        xyz=np.where(role == "tie", np.nan, _observed(points.xyz, points.sigma, given)),
        sigma=np.where(role == "control", points.sigma, np.inf),
        check_sigma=np.where(role == "check", points.sigma, np.nan),
    )


def _given_curve(
    feature: Feature, start_knots_m: float, start: np.random.Generator, given: np.random.Generator | None
) -> Curve:
    """The curve as people know it: known values with their errors, wrong starts elsewhere."""
    known = _observed(feature.values, feature.sigma, given)
    values = np.where(np.isfinite(feature.sigma), known, perturbed(feature.values, start_knots_m, start))
    curve = feature.curve(values)
    if feature.role == "check":
        curve = replace(curve, check_values=samples(feature, CHECK_SAMPLES))
    return curve if feature.role == "control" else replace(curve, reference=feature.values)
