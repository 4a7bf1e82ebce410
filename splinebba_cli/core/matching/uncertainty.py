"""What is known of orientations and curves at a moment: dispersions that predict where a curve is seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project_with_jacobian
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray, IntArray


@dataclass(frozen=True)
class Uncertainty:
    """Dispersions of orientations and curves, correlations between them neglected."""

    eop: FloatArray  # (m, 6, 6) of theta, X0
    shape: FloatArray  # (nc,) metres, of a curve in every direction across; 0 where it is held
    noise_factor: float = 1.0  # of the sigma of points

    def of_curves(self, scene: Scene, curve: IntArray, u: FloatArray, h: FloatArray) -> FloatArray:
        """Variance h' S h of curve points, (k,) mm^2; h (k, 3) mm/m."""
        return np.asarray(self.shape[curve] ** 2 * np.sum(h * h, axis=1))

    def largest_in_photo(self, scene: Scene) -> FloatArray:
        """Largest common standard deviation in every image, (m,) mm, at the curves that it sees."""
        curves = scene.curves
        owner = np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start))
        middle = scene.curves.evaluate(scene.coefficients, owner, curves.left + 0.5 * curves.length)[0]
        largest = np.zeros(len(scene.position))
        for image in np.unique(scene.image):
            rows = np.flatnonzero(np.isfinite(middle).all(axis=1))
            xy, jacobian = project_with_jacobian(
                np.full(len(rows), scene.principal_distance[image]),
                np.broadcast_to(scene.rotation[image], (len(rows), 3, 3)),
                np.broadcast_to(scene.position[image], (len(rows), 3)),
                middle[rows],
            )
            own = scene.xy[scene.image == image]
            reach = 0.25 * np.ptp(own, axis=0).max() + 1e-9
            near = np.flatnonzero(
                ((xy >= own.min(axis=0) - reach) & (xy <= own.max(axis=0) + reach)).all(axis=1)
            )
            if not len(near):
                near = np.flatnonzero(np.isfinite(xy).all(axis=1))
            if not len(near):
                continue
            g, a = jacobian.orientation[near], jacobian.object_xyz[near]
            of_images = np.einsum("nij,jk,nik->n", g, self.eop[image], g)
            of_curves = self.shape[owner[rows[near]]] ** 2 * np.einsum("nij,nij->n", a, a) / 2.0
            largest[image] = float(np.sqrt(np.quantile(of_images + of_curves, 0.98)))
        return largest
