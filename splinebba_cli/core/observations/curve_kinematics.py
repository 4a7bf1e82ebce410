"""A curve as one image sees it: place, first and second derivative in photo axes, at many locations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.image_velocity import (
    image_velocity,
    orientation_gradient,
    velocity_gradient,
)
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State


@dataclass(frozen=True)
class VelocityRows:
    """Derivatives of scalar functions of the image velocity over the parameters."""

    orientation: FloatArray  # (K, 6) d/d(theta, X0)
    coefficients: FloatArray  # (K, w, 3) d/dP_j


@dataclass(frozen=True)
class CurveKinematics:
    """Curve points in photo axes, and what is needed to differentiate functions of their image velocity."""

    principal_distance: FloatArray  # (K,)
    rotation: FloatArray  # (K, 3, 3)
    q: FloatArray  # (K, 3) R'(X - X0)
    q1: FloatArray  # (K, 3) R'X'
    q2: FloatArray  # (K, 3) R'X''
    weights: FloatArray  # (K, w) N_j
    slopes: FloatArray  # (K, w) N_j'

    @classmethod
    def at(
        cls, prepared: Prepared, state: State, image: IntArray, segment: IntArray, t: FloatArray
    ) -> CurveKinematics:
        """Kinematics at places of segments, seen by images; all (K,)."""
        curves, rotation = prepared.curves, state.rotation[image]
        local = state.coefficients[curves.columns[segment]]
        weights = [curves.weights(segment, t, order) for order in range(3)]
        xyz, first, second = (np.matmul(w[:, None, :], local)[:, 0] for w in weights)
        q, q1, q2 = (
            np.matmul(v[:, None, :], rotation)[:, 0] for v in (xyz - state.position[image], first, second)
        )
        return cls(prepared.principal_distance[image], rotation, q, q1, q2, weights[0], weights[1])

    def velocity(self) -> FloatArray:
        """Image velocity (x', y'), (K, 2) mm per unit of u; NaN behind the camera."""
        return image_velocity(self.principal_distance, self.q, self.q1)

    def slope(self, weights: FloatArray) -> FloatArray:
        """Derivatives d/du (K,) of functions of the velocity with derivatives `weights` (K, 2) over it."""
        g, g1 = velocity_gradient(self.principal_distance, self.q, self.q1, weights)
        return np.asarray(np.sum(g * self.q1, axis=1) + np.sum(g1 * self.q2, axis=1))

    def gradients(self, weights: FloatArray) -> VelocityRows:
        """Derivatives over orientation and coefficients of functions with derivatives `weights` (K, 2)."""
        g, g1 = velocity_gradient(self.principal_distance, self.q, self.q1, weights)
        turned, turned1 = (np.matmul(self.rotation, v[:, :, None])[:, :, 0] for v in (g, g1))
        return VelocityRows(
            orientation=orientation_gradient(self.rotation, self.q, self.q1, g, g1),
            coefficients=self.weights[:, :, None] * turned[:, None]
            + self.slopes[:, :, None] * turned1[:, None],
        )
