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
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network, PointObservations, Role
from splinebba_cli.core.state import ImageRays, Prepared, State

STEPS = 8  # of Gauss and Newton
SETTLED = 1e-3  # sigma along the curve
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
    def of(cls, scene: Scene, rows: IntArray, curve: IntArray, factor: FloatArray) -> HeldPoints:
        """Some of the unlabelled points, on curves (k,)."""
        return cls(rows, scene.image[rows], curve, ImageRays(scene.xy[rows], scene.whitening[rows]), factor)

    def __len__(self) -> int:
        return len(self.rows)

    def added_to(self, network: Network) -> Network:
        """The network with a fixed object point for every one of them, behind its own points."""
        points, seen = network.points, network.point_observations
        count, first = len(self), len(points.ids)
        control: Role = "control"
        three = np.zeros((count, 3))
        return replace(
            network,
            points=replace(
                points,
                ids=points.ids + ("",) * count,
                role=(*points.role, *[control] * count),
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
    polynomials: FloatArray,
    u: FloatArray,
    prepared: Prepared,
    state: State,
) -> tuple[FloatArray, FloatArray, Prepared]:
    """Foot points of held points at a state, their places in the object, and the network observed across curves there.

    Parameters
    ----------
    polynomials : (S, K, 3) of the segments of all curves
    u : (k,) near the foot points
    prepared : of a network with the points added (:meth:`HeldPoints.added_to`)

    Returns
    -------
    u (k,), xyz (k, 3) metres, prepared
    """
    whitening = points.rays.whitening / points.factor[:, None, None]
    search = _FootSearch(points, curves, polynomials, whitening, prepared, state)
    found = search.settled(u)
    tangent = found.along / np.linalg.norm(found.along, axis=1, keepdims=True)
    turn = np.stack([np.column_stack([-tangent[:, 1], tangent[:, 0]]), NOTHING * tangent], axis=1)
    own = len(prepared.point_rays.xy) - len(points)
    rays = ImageRays(
        np.vstack([prepared.point_rays.xy[:own], points.rays.xy]),
        np.concatenate([prepared.point_rays.whitening[:own], np.matmul(turn, whitening)]),
    )
    return found.u, found.xyz, replace(prepared, point_rays=rays)


@dataclass(frozen=True)
class _Feet:
    u: FloatArray  # (k,)
    xyz: FloatArray  # (k, 3)
    along: FloatArray  # (k, 2) whitened d p / d u
    residual: FloatArray  # (k, 2) whitened

    @property
    def square(self) -> FloatArray:
        return np.asarray(np.sum(self.residual**2, axis=1))

    @property
    def step(self) -> FloatArray:
        """Of Gauss and Newton, (k,) in u."""
        return np.asarray(-np.sum(self.along * self.residual, axis=1) / np.sum(self.along**2, axis=1))

    def chosen(self, other: _Feet, better: BoolArray) -> _Feet:
        """Those of another one where they are better."""
        return _Feet(
            *(
                np.where(better if a.ndim == 1 else better[:, None], b, a)
                for a, b in zip(
                    (self.u, self.xyz, self.along, self.residual),
                    (other.u, other.xyz, other.along, other.residual),
                    strict=True,
                )
            )
        )


@dataclass(frozen=True)
class _FootSearch:
    """Steps towards foot points that never get worse."""

    points: HeldPoints
    curves: CurveSet
    polynomials: FloatArray
    whitening: FloatArray  # (k, 2, 2)
    prepared: Prepared
    state: State

    def at(self, u: FloatArray) -> _Feet:
        """Places of the curves."""
        image = self.points.image
        segment, t = self.curves.locate(self.points.curve, u)
        xyz, rate, _ = self.curves.derivatives(self.polynomials, segment, t)
        camera = (
            self.prepared.principal_distance[image],
            self.state.rotation[image],
            self.state.position[image],
        )
        xy, jacobian = project_with_jacobian(*camera, xyz)
        along = np.matmul(self.whitening, np.matmul(jacobian.object_xyz, rate[:, :, None]))[:, :, 0]
        residual = np.matmul(self.whitening, (xy - self.points.rays.xy)[:, :, None])[:, :, 0]
        return _Feet(u, xyz, along, residual)

    def settled(self, u: FloatArray) -> _Feet:
        """Foot points near places u (k,), inside the domains of the curves."""
        curves, curve = self.curves, self.points.curve
        low = np.where(curves.closed[curve], -np.inf, curves.first[curve])
        high = np.where(curves.closed[curve], np.inf, curves.last[curve])
        best, share = self.at(u), np.ones(len(u))
        for _ in range(STEPS):
            trial = np.clip(best.u + share * best.step, low, high)
            moved = np.abs(trial - best.u) * np.linalg.norm(best.along, axis=1)
            if moved.max(initial=0.0) < SETTLED:
                break
            found = self.at(trial)
            better = found.square <= best.square
            share = np.where(better, 1.0, 0.5 * share)
            best = best.chosen(found, better)
        return best
