"""What is known of orientations and curves at a moment: dispersions that predict where a curve is seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project, project_with_jacobian
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.estimation.conditioned_solution import ConditionedSolution
from splinebba_cli.core.estimation.window_map import WindowMap
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.state import Prepared

SEGMENTS = 20_000  # of all curves whose middles are looked at
PLACES = 200  # of an image, the same


@dataclass(frozen=True)
class CurveCofactors:
    """Dispersions of adjusted curves: blocks of the selected inverse under every segment."""

    number: IntArray  # (nc,) of a curve among the adjusted ones, -1: none
    curves: CurveSet  # adjusted ones
    window: FloatArray  # (S, 3 w, 3 w) of the coefficients under a segment

    @classmethod
    def of(cls, kept: BoolArray, prepared: Prepared, solved: ConditionedSolution) -> CurveCofactors:
        """Of the curves that took part in a solution.

        Parameters
        ----------
        kept : (nc,) which of all curves took part
        """
        assembler, factor = solved.assembler, solved.solution.factor
        assert factor is not None
        every = prepared.curves.columns
        mask = assembler.layout.coefficient_mask[every].reshape(len(every), -1)
        free = np.flatnonzero(mask.any(axis=1))
        window = np.zeros((*mask.shape, mask.shape[1]))
        places = WindowMap.of(assembler.structure, assembler.slots_of_columns(every[free]))
        window[free] = places.gather(factor.selected_inverse().values)
        number = np.where(kept, np.cumsum(kept) - 1, -1)
        return cls(number, prepared.curves, window * mask[:, :, None] * mask[:, None, :])

    def variance(self, curve: IntArray, u: FloatArray, h: FloatArray) -> FloatArray:
        """h' S h of curve points, (k,) mm^2; curve numbers of the adjusted ones, h (k, 3) mm/m."""
        segment, t = self.curves.locate(curve, u)
        g = (self.curves.weights(segment, t)[:, :, None] * h[:, None, :]).reshape(
            len(u), self.window.shape[1]
        )
        return np.asarray(
            np.maximum(np.sum(np.matmul(g[:, None, :], self.window[segment])[:, 0] * g, axis=1), 0.0)
        )


@dataclass(frozen=True)
class Uncertainty:
    """Dispersions of orientations and curves, correlations between them neglected."""

    eop: FloatArray  # (m, 6, 6) of theta, X0
    shape: FloatArray  # (nc,) metres, of a curve in every direction across; 0 where it is held
    noise_factor: float = 1.0  # of the sigma of points
    inflation: float = 1.0  # of the variances of orientations and adjusted curves
    cofactors: CurveCofactors | None = None  # of curves that an adjustment has moved

    def of_curves(self, scene: Scene, curve: IntArray, u: FloatArray, h: FloatArray) -> FloatArray:
        """Variance h' S h of curve points, (k,) mm^2; h (k, 3) mm/m."""
        variance = self.shape[curve] ** 2 * np.sum(h * h, axis=1)
        if self.cofactors is not None:
            number = self.cofactors.number[curve]
            rows = np.flatnonzero(number >= 0)
            variance[rows] = self.inflation * self.cofactors.variance(number[rows], u[rows], h[rows])
        return np.asarray(variance)

    def of_images(self, image: IntArray, g: FloatArray) -> FloatArray:
        """Variance g' S g of projections, (k,) mm^2; g (k, 6) per rad and m."""
        return np.asarray(
            self.inflation * np.sum(np.matmul(g[:, None, :], self.eop[image])[:, 0] * g, axis=1)
        )

    def largest_in_photo(self, scene: Scene) -> FloatArray:
        """Largest common standard deviation in every image, (m,) mm, at the curves that it sees."""
        curves = scene.curves
        segment = np.arange(0, len(curves.left), max(1, len(curves.left) // SEGMENTS))
        place = curves.left[segment] + 0.5 * curves.length[segment]
        middle = scene.curves.evaluate(scene.coefficients, curves.owner[segment], place)[0]
        known = np.flatnonzero(np.isfinite(middle).all(axis=1))
        segment, place, middle = segment[known], place[known], middle[known]
        largest = np.zeros(len(scene.position))
        order = np.argsort(scene.image, kind="stable")
        bounds = np.searchsorted(scene.image[order], np.arange(len(scene.position) + 1))
        for image in np.flatnonzero(np.diff(bounds)).tolist():
            own = scene.xy[order[bounds[image] : bounds[image + 1]]]
            near = _near(scene, image, own, middle)
            variance = self._variance(scene, image, curves.owner[segment[near]], place[near], middle[near])
            if len(near):
                largest[image] = float(np.sqrt(np.quantile(variance, 0.98)))
        return largest

    def _variance(
        self, scene: Scene, image: int, curve: IntArray, u: FloatArray, xyz: FloatArray
    ) -> FloatArray:
        """Sum of the variances in x and y of curve points as an image sees them, (k,) mm^2."""
        count = len(u)
        _, jacobian = project_with_jacobian(
            np.full(count, scene.principal_distance[image]),
            np.broadcast_to(scene.rotation[image], (count, 3, 3)),
            np.broadcast_to(scene.position[image], (count, 3)),
            xyz,
        )
        variance = np.zeros(count)
        for row in range(2):
            variance += self.of_images(np.full(count, image), jacobian.orientation[:, row])
            variance += self.of_curves(scene, curve, u, jacobian.object_xyz[:, row])
        return variance


def _near(scene: Scene, image: int, own: FloatArray, xyz: FloatArray) -> IntArray:
    """Some of the places that an image sees near its points, else some that it sees at all."""
    xy = project(
        scene.principal_distance[image : image + 1], scene.rotation[image : image + 1],
        scene.position[image : image + 1], xyz,
    )  # fmt: skip
    reach = 0.25 * float(np.ptp(own, axis=0).max()) + 1e-9
    with np.errstate(invalid="ignore"):
        inside = ((xy >= own.min(axis=0) - reach) & (xy <= own.max(axis=0) + reach)).all(axis=1)
    near = np.flatnonzero(inside)
    if not len(near):
        near = np.flatnonzero(np.isfinite(xy).all(axis=1))
    return near[:: max(1, len(near) // PLACES)]
