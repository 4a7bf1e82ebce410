"""Labelled points on held curves as fixed object points that are observed across their curve only.

A curve that is held brings no unknowns.  Near a foot point X(u) the distance across it is

    n'(W (p(X(u)) - xy)),    n a unit vector, n . W d p / d u = 0,

so that X(u) may stand for the curve while the orientation moves a little; then the foot point is sought again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import FloatArray, IntArray, Network, PointObservations
from splinebba_cli.core.state import ImageRays, Prepared, State, image_rays

STEPS = 4  # of Newton's method; the points begin near their foot points
NOTHING = 1e-9  # weight along the curve: none, but keeps the whitening regular


@dataclass(frozen=True)
class HeldPoints:
    """Measured points on held curves."""

    rows: IntArray  # (k,) of the unlabelled points
    image: IntArray  # (k,)
    curve: IntArray  # (k,)
    rays: ImageRays  # with the whitening of the measurement
    factor: FloatArray  # (k,) of their sigma

    @classmethod
    def of(cls, network: Network, rows: IntArray, curve: IntArray, factor: FloatArray) -> HeldPoints:
        """Some of the unlabelled points, on curves (k,)."""
        points = network.unlabelled
        rays = image_rays(network, points.image[rows], points.photo_xy[rows], points.sigma[rows])
        return cls(rows, points.image[rows], curve, rays, factor)

    def __len__(self) -> int:
        return len(self.rows)

    def weighted(self, factor: FloatArray) -> HeldPoints:
        """With factors (k,) of the sigma."""
        return replace(self, factor=factor)

    def added_to(self, network: Network) -> Network:
        """The network with a fixed object point for every one of them, behind its own points."""
        points, seen = network.points, network.point_observations
        count, first = len(self), len(points.ids)
        three = np.zeros((count, 3))
        return replace(
            network,
            points=replace(
                points,
                ids=points.ids + ("",) * count,
                role=points.role + ("control",) * count,
                xyz=np.vstack([points.xyz, three]),
                sigma=np.vstack([points.sigma, three]),
                check_sigma=np.vstack([points.check_sigma, np.full((count, 3), np.nan)]),
            ),
            point_observations=PointObservations(
                image=np.concatenate([seen.image, self.image]),
                point=np.concatenate([seen.point, first + np.arange(count)]),
                photo_xy=np.vstack([seen.photo_xy, self.rays.xy]),
                sigma=np.vstack([seen.sigma, np.ones((count, 2))]),
            ),
        )


def at_feet(
    points: HeldPoints,
    curves: CurveSet,
    coefficients: FloatArray,
    u: FloatArray,
    prepared: Prepared,
    state: State,
) -> tuple[FloatArray, FloatArray, Prepared]:
    """Foot points of held points at a state, their places in the object, and the network observed across curves there.

    Parameters
    ----------
    u : (k,) near the foot points
    prepared : of a network with the points added (:meth:`HeldPoints.added_to`)

    Returns
    -------
    u (k,), xyz (k, 3) metres, prepared
    """
    curve, image = points.curve, points.image
    camera = prepared.principal_distance[image], state.rotation[image], state.position[image]
    low = np.where(curves.closed[curve], -np.inf, curves.first[curve])
    high = np.where(curves.closed[curve], np.inf, curves.last[curve])
    whitening = points.rays.whitening / points.factor[:, None, None]
    best, least, share = u, np.full(len(u), np.inf), np.ones(len(u))
    step = np.zeros(len(u))
    for last in [False] * STEPS + [True]:
        xyz, rate = curves.evaluate(coefficients, curve, u, (0, 1))
        xy, jacobian = project_with_jacobian(*camera, xyz)
        along = np.matmul(whitening, np.matmul(jacobian.object_xyz, rate[:, :, None]))[:, :, 0]
        r = np.matmul(whitening, (xy - points.rays.xy)[:, :, None])[:, :, 0]
        better = np.sum(r * r, axis=1) <= least
        best, least = np.where(better, u, best), np.where(better, np.sum(r * r, axis=1), least)
        share = np.where(better, 1.0, 0.5 * share)
        step = np.where(better, -np.sum(along * r, axis=1) / np.sum(along * along, axis=1), step)
        if not last:
            u = np.clip(best + share * step, low, high)
    xyz, rate = curves.evaluate(coefficients, curve, best, (0, 1))
    along = np.matmul(whitening, np.matmul(project_with_jacobian(*camera, xyz)[1].object_xyz, rate[:, :, None]))[:, :, 0]
    tangent = along / np.linalg.norm(along, axis=1, keepdims=True)
    turn = np.stack([np.column_stack([-tangent[:, 1], tangent[:, 0]]), NOTHING * tangent], axis=1)
    own = len(prepared.point_rays.xy) - len(points)
    rays = ImageRays(
        np.vstack([prepared.point_rays.xy[:own], points.rays.xy]),
        np.concatenate([prepared.point_rays.whitening[:own], np.matmul(turn, whitening)]),
    )
    return best, xyz, replace(prepared, point_rays=rays)
