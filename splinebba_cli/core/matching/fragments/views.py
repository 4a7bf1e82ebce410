"""Oriented images: rays of image points, projections, and how a photo point moves with an object point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project, project_with_jacobian
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network


@dataclass(frozen=True)
class Views:
    """Cameras in space, one row an image."""

    rotation: FloatArray  # (m, 3, 3) object from photo
    position: FloatArray  # (m, 3) metres
    principal_distance: FloatArray  # (m,) mm

    @classmethod
    def of(cls, network: Network, rotation: FloatArray, position: FloatArray) -> Views:
        """The images of a network with their present orientations."""
        c = np.array([camera.principal_distance_mm for camera in network.cameras])
        return cls(rotation, position, c[network.images.camera])

    @property
    def oriented(self) -> BoolArray:
        """Images with an orientation, (m,)."""
        finite = np.isfinite(self.position).all(axis=1) & np.isfinite(self.rotation).all(axis=(1, 2))
        return np.asarray(finite)

    def rays(self, image: IntArray, xy: FloatArray) -> FloatArray:
        """Rays R (x, y, -c)' of photo points, (n, 3); an object point lies at X0 + depth ray.

        The depth of this package is the distance along the camera axis over the principal distance, m/mm.
        """
        local = np.column_stack([xy, -self.principal_distance[image]])
        return np.asarray(np.matmul(self.rotation[image], local[:, :, None])[:, :, 0])

    def turned(self, image: IntArray, along: FloatArray) -> FloatArray:
        """Directions of the photo plane in space, R (x, y, 0)', (n, 3)."""
        return np.asarray(np.matmul(self.rotation[image][:, :, :2], along[:, :, None])[:, :, 0])

    def project(self, image: IntArray, xyz: FloatArray) -> FloatArray:
        """Photo points (n, 2) mm, corrected frame; NaN behind the camera."""
        return project(self.principal_distance[image], self.rotation[image], self.position[image], xyz)

    def project_with_jacobian(self, image: IntArray, xyz: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Photo points (n, 2) and their derivatives by the object point (n, 2, 3)."""
        xy, jacobian = project_with_jacobian(
            self.principal_distance[image], self.rotation[image], self.position[image], xyz
        )
        return xy, jacobian.object_xyz
