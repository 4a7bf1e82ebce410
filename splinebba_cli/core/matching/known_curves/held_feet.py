"""Labelled points on held curves as fixed object points that are observed across their curve only.

A curve that is held brings no unknowns.  Near a foot point X(u) the distance across it is

    n'(W (p(X(u)) - xy)),    n a unit vector, n . W d p / d u = 0,

so that X(u) may stand for the curve while the orientation moves a little; then the foot point is sought again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.chains import Chains
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import (
    ArcLengths,
    CurveObservations,
    FloatArray,
    IntArray,
    Network,
    PointObservations,
    Role,
    Tangents,
)
from splinebba_cli.core.observations.locations import refine_locations
from splinebba_cli.core.state import ImageRays, Prepared, ScalarMeasurements, State

NOTHING = 1e-9  # weight along the curve: none, but keeps the whitening regular


@dataclass(frozen=True)
class HeldPoints:
    """Measured points on held curves."""

    network: Network  # with all its curves
    scene: Scene  # where these stand
    rows: IntArray  # (k,) of the unlabelled points
    curve: IntArray  # (k,)
    factor: FloatArray  # (k,) of their sigma

    @cached_property
    def image(self) -> IntArray:
        """Their images, (k,)."""
        return np.asarray(self.scene.image[self.rows])

    @cached_property
    def rays(self) -> ImageRays:
        """Their corrected coordinates and whitening."""
        whitening = self.scene.whitening[self.rows] / self.factor[:, None, None]
        return ImageRays(self.scene.xy[self.rows], whitening)

    def __len__(self) -> int:
        return len(self.rows)

    @cached_property
    def on_curves(self) -> Prepared:
        """They alone, as measured points of curves."""
        count, nothing = len(self), ScalarMeasurements(np.zeros(0), np.zeros(0), np.zeros(0))
        points = self.network.unlabelled
        network = replace(
            self.network,
            curve_observations=CurveObservations(
                self.image, self.curve, points.photo_xy[self.rows], points.sigma[self.rows],
                np.full(count, np.nan), np.full(count, -1),
            ),
            arc_lengths=ArcLengths.none(),
            tangents=Tangents.none(),
        )  # fmt: skip
        return Prepared(
            network=network,
            curves=self.scene.curves,
            principal_distance=self.scene.principal_distance,
            point_rays=ImageRays(np.zeros((0, 2)), np.zeros((0, 2, 2))),
            curve_rays=self.rays,
            arc_lengths=nothing,
            tangents=nothing,
            chains=Chains.of(network),
        )

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


@dataclass(frozen=True)
class Feet:
    """Foot points of held points."""

    u: FloatArray  # (k,)
    xyz: FloatArray  # (k, 3) metres
    across: FloatArray  # (k, 2, 2) 1/mm, whitening of residuals across the curve and, with nearly no weight, along it


def feet(points: HeldPoints, u: FloatArray, state: State) -> Feet:
    """Foot points at the orientations of a state.

    Parameters
    ----------
    u : (k,) near the foot points
    """
    prepared, image, curves = points.on_curves, points.image, points.scene.curves
    of_curves = replace(state, coefficients=points.scene.coefficients, location=u)
    u = refine_locations(prepared, of_curves).location
    segment, t = curves.locate(points.curve, u)
    xyz, rate, _ = curves.derivatives(points.scene.polynomials, segment, t)
    _, jacobian = project_with_jacobian(
        prepared.principal_distance[image], state.rotation[image], state.position[image], xyz
    )
    whitening = points.rays.whitening
    along = np.matmul(whitening, np.matmul(jacobian.object_xyz, rate[:, :, None]))[:, :, 0]
    tangent = along / np.linalg.norm(along, axis=1, keepdims=True)
    turn = np.stack([np.column_stack([-tangent[:, 1], tangent[:, 0]]), NOTHING * tangent], axis=1)
    return Feet(u, xyz, np.matmul(turn, whitening))


def observed_at(points: HeldPoints, found: Feet, prepared: Prepared) -> Prepared:
    """The network with the points added (:meth:`HeldPoints.added_to`), observed across curves at foot points."""
    own = len(prepared.point_rays.xy) - len(points)
    rays = ImageRays(
        np.vstack([prepared.point_rays.xy[:own], points.rays.xy]),
        np.concatenate([prepared.point_rays.whitening[:own], found.across]),
    )
    return replace(prepared, point_rays=rays)
