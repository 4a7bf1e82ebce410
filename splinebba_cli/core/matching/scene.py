"""Curves as images see them at present, and the unlabelled points: what candidates are searched in."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import FloatArray, IntArray, Network
from splinebba_cli.core.state import Prepared, State, image_rays, prepare


@dataclass(frozen=True)
class Scene:
    """Projected curves and measured points, in the corrected photo frames (mm)."""

    curves: CurveSet
    coefficients: FloatArray  # (C, 3) metres, local frame
    polynomials: FloatArray  # (S, K, 3) of the segments
    rotation: FloatArray  # (m, 3, 3) object from photo
    position: FloatArray  # (m, 3) metres
    principal_distance: FloatArray  # (m,) mm
    image: IntArray  # (n,) of the unlabelled points
    xy: FloatArray  # (n, 2) mm
    whitening: FloatArray  # (n, 2, 2) 1/mm
    chain: IntArray  # (n,) -1: single
    direction: FloatArray  # (n,) rad in the corrected frame, up to half a turn; NaN unknown

    def at(self, state: State) -> Scene:
        """The same points before curves and orientations of another state."""
        return replace(
            self,
            coefficients=state.coefficients,
            polynomials=self.curves.segment_polynomials(state.coefficients),
            rotation=state.rotation,
            position=state.position,
        )

    @cached_property
    def noise(self) -> FloatArray:
        """Largest standard deviation of every point, (n,) mm."""
        w = self.whitening
        trace = np.sum(w * w, axis=(1, 2))
        determinant = np.abs(w[:, 0, 0] * w[:, 1, 1] - w[:, 0, 1] * w[:, 1, 0])
        least = 0.5 * (trace - np.sqrt(np.maximum(trace**2 - 4.0 * determinant**2, 0.0)))
        return np.asarray(1.0 / np.sqrt(least))

    @classmethod
    def of(cls, network: Network, state: State, prepared: Prepared | None = None) -> Scene:
        """The unlabelled points of a network before curves and orientations of a state."""
        prepared = prepare(network) if prepared is None else prepared
        points = network.unlabelled
        rays = image_rays(network, points.image, points.photo_xy, points.sigma)
        return cls(
            curves=prepared.curves,
            coefficients=state.coefficients,
            polynomials=prepared.curves.segment_polynomials(state.coefficients),
            rotation=state.rotation,
            position=state.position,
            principal_distance=prepared.principal_distance,
            image=points.image,
            xy=rays.xy,
            whitening=rays.whitening,
            chain=points.chain,
            direction=_corrected_direction(points.direction, points.sigma, rays.whitening),
        )


def _corrected_direction(direction: FloatArray, sigma: FloatArray, whitening: FloatArray) -> FloatArray:
    """Directions turned by the Jacobian of the correction, (n,) rad."""
    correction = np.linalg.inv(whitening * sigma[:, :, None])
    along = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    turned = np.matmul(correction, along[:, :, None])[:, :, 0]
    return np.asarray(np.arctan2(turned[:, 1], turned[:, 0]))
