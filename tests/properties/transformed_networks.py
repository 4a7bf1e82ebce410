"""A small six-image network, and the same network written differently: other frame, other order, other units."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from splinebba_cli.core.adjustment import adjust
from splinebba_cli.core.camera.rotation import angle_jacobian, angles_from_rotation
from splinebba_cli.core.network import Curve, FloatArray, IntArray, Network, RotationSequence
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.simulation.six_image_block import simulate_block
from tests.core.small_networks import select_curve_points


@dataclass(frozen=True)
class Similarity:
    """X' = scale Q X + shift."""

    scale: float
    rotation: FloatArray  # (3, 3)
    shift: FloatArray  # (3,)

    def positions(self, xyz: FloatArray) -> FloatArray:
        """Points (n, 3) in the new frame."""
        return np.asarray(self.scale * xyz @ self.rotation.T + self.shift)

    def vectors(self, xyz: FloatArray) -> FloatArray:
        """Differences of points (n, 3) in the new frame."""
        return np.asarray(self.scale * xyz @ self.rotation.T)

    def dispersion(self, blocks: FloatArray) -> FloatArray:
        """Dispersions (n, 3, 3) of points in the new frame."""
        return np.asarray(self.scale**2 * self.rotation @ blocks @ self.rotation.T)


@cache
def small_network() -> Network:
    """Six images, control, tie and check points, partial, tie and check splines, prior positions.

    Whatever is known is known equally well in all directions, so that a turned frame can say the same.
    """
    network, truth = simulate_block(
        "six-image-mixed", 3, start_position_m=0.3, start_angle_deg=0.05, start_knots_m=0.2
    )
    network = select_curve_points(network, np.arange(0, len(network.curve_observations), 2))
    prior, sigma = np.full((6, 6), np.nan), np.full((6, 6), np.inf)
    prior[[0, 3], 3:] = truth.eop[[0, 3], 3:] + [[0.1, -0.05, 0.08], [-0.1, 0.02, 0.06]]
    sigma[[0, 3], 3:] = 0.1
    first = network.curves[0]
    known = np.isfinite(first.sigma).any(axis=1)
    weights = np.where(known[:, None], 0.05, np.inf) * np.ones(3)
    weights[0] = 0.0
    values = np.where(known[:, None], truth.curves[0] + 0.02, first.values)
    values[0] = truth.curves[0][0]
    curves = (replace(first, sigma=weights, values=values), *network.curves[1:])
    images = replace(network.images, prior=prior, prior_sigma=sigma)
    return replace(network, images=images, curves=curves)


@cache
def original() -> AdjustmentResult:
    """The small network adjusted."""
    return adjust(small_network())


def moved(network: Network, to: Similarity) -> Network:
    """The network in another object frame."""
    images, points = network.images, network.points
    prior = images.prior.copy()
    prior[:, 3:] = to.positions(prior[:, 3:])
    sigma = images.prior_sigma.copy()
    sigma[:, 3:] *= to.scale
    images = replace(
        images,
        rotation=to.rotation @ images.rotation,
        position=to.positions(images.position),
        prior=prior,
        prior_sigma=sigma,
    )
    points = replace(
        points,
        xyz=to.positions(points.xyz),
        sigma=points.sigma * to.scale,
        check_sigma=points.check_sigma * to.scale,
    )
    return replace(
        network, images=images, points=points, curves=tuple(moved_curve(c, to) for c in network.curves)
    )


def moved_curve(curve: Curve, to: Similarity) -> Curve:
    """A spline in another object frame; all of its values are positions."""
    given = [None if v is None else to.positions(v) for v in (curve.reference, curve.check_values)]
    values, sigma = to.positions(curve.values), curve.sigma * to.scale
    return replace(curve, values=values, sigma=sigma, reference=given[0], check_values=given[1])


def permuted(network: Network, images: IntArray, points: IntArray, curves: IntArray, seed: int) -> Network:
    """Rows of images, points, curves and observations in another order; `images[i]` is the old number of the new i."""
    order = np.random.default_rng(seed)
    old, given = network.images, network.points
    rays, seen = network.point_observations, network.curve_observations
    new_image, new_point, new_curve = np.argsort(images), np.argsort(points), np.argsort(curves)
    p, q = order.permutation(len(rays)), order.permutation(len(seen))
    return replace(
        network,
        images=replace(
            old, ids=tuple(old.ids[i] for i in images), camera=old.camera[images], rotation=old.rotation[images],
            position=old.position[images], sequence=tuple(old.sequence[i] for i in images), prior=old.prior[images],
            prior_sigma=old.prior_sigma[images],
        ),
        points=replace(
            given, ids=tuple(given.ids[i] for i in points), role=tuple(given.role[i] for i in points),
            xyz=given.xyz[points], sigma=given.sigma[points], check_sigma=given.check_sigma[points],
        ),
        curves=tuple(network.curves[i] for i in curves),
        point_observations=replace(
            rays, image=new_image[rays.image[p]], point=new_point[rays.point[p]], photo_xy=rays.photo_xy[p],
            sigma=rays.sigma[p],
        ),
        curve_observations=replace(
            seen, image=new_image[seen.image[q]], curve=new_curve[seen.curve[q]], photo_xy=seen.photo_xy[q],
            sigma=seen.sigma[q], location=seen.location[q], segment=seen.segment[q],
        ),
    )  # fmt: skip


def observation_order(network: Network, seed: int) -> tuple[IntArray, IntArray]:
    """The orders of the observations of points and of curves that :func:`permuted` draws."""
    order = np.random.default_rng(seed)
    return order.permutation(len(network.point_observations)), order.permutation(
        len(network.curve_observations)
    )


def other_photo_unit(network: Network, factor: float) -> Network:
    """All photo coordinates, principal distances and their sigma in a unit `factor` times smaller."""
    rays, seen = network.point_observations, network.curve_observations
    return replace(
        network,
        cameras=tuple(
            replace(
                camera,
                principal_distance_mm=factor * camera.principal_distance_mm,
                principal_point_mm=factor * camera.principal_point_mm,
                radial=camera.radial / factor ** np.array([2.0, 4.0, 6.0]),
                decentring=camera.decentring / factor,
            )
            for camera in network.cameras
        ),
        point_observations=replace(rays, photo_xy=factor * rays.photo_xy, sigma=factor * rays.sigma),
        curve_observations=replace(seen, photo_xy=factor * seen.photo_xy, sigma=factor * seen.sigma),
    )


def rotation_dispersion(result: AdjustmentResult) -> FloatArray:
    """Dispersion (m, 6, 6) of rotation vectors in the photo frames and of positions, whatever the angles are."""
    out = np.empty_like(result.images.dispersion)
    for i, block in enumerate(result.images.dispersion):
        sequence: RotationSequence = result.network.images.sequence[i]
        back = np.eye(6)
        back[:3, :3] = angle_jacobian(angles_from_rotation(result.images.rotation[i], sequence), sequence)
        out[i] = back @ block @ back.T
    return out
