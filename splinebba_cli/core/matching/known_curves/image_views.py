"""Views of images for their alignment: some of the points, and samples of the curves that may be seen on them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from splinebba_cli.core.matching.known_curves.chain_directions import Directions
from splinebba_cli.core.matching.known_curves.curve_samples import CurveSamples
from splinebba_cli.core.matching.known_curves.image_view import ImageView, Pose
from splinebba_cli.core.matching.known_curves.loop_context import LoopContext
from splinebba_cli.core.matching.known_curves.shape_gates import narrow_shapes
from splinebba_cli.core.matching.scene import Scene
from splinebba_cli.core.network import FloatArray, IntArray

POINTS = 600  # of an image that take part
SAMPLES = 4_000  # of curves in one image, about
ROUGHLY = 50_000  # samples of all curves that tell which of them an image sees
FINEST = 3.0  # sigma of a point, between samples of a curve
COARSEST = 20.0  # sigma, or half of the range of the prior
REACH = 4.0  # standard deviations of the prior: samples farther from all points take no part
MARGIN = 20.0  # sigma of a point, the same


@dataclass(frozen=True)
class ImageViews:
    """What views of all images have in common."""

    context: LoopContext
    scene: Scene
    directions: Directions
    rough: CurveSamples  # of all curves

    @classmethod
    def of(cls, context: LoopContext, scene: Scene) -> ImageViews:
        """Of all images at a state."""
        shaped, curves = context.start.shaped, scene.curves
        chords = np.linalg.norm(scene.polynomials[shaped[curves.owner], 1:4].sum(axis=1), axis=1)
        spacing = max(float(np.nansum(chords)) / ROUGHLY, 1e-9)
        rough = CurveSamples.of(curves, scene.coefficients, shaped, spacing)
        return cls(context, scene, context.traced.directions, rough)

    def view(self, image: int, spread: float) -> ImageView:
        """Of one image whose curves may be off by a standard deviation, mm."""
        scene = self.scene
        rows = np.flatnonzero((scene.image == image) & self.context.oriented)
        if len(rows) > POINTS:
            rows = rows[np.linspace(0, len(rows) - 1, POINTS).astype(np.int64)]
        sigma = 1.0 / np.sqrt(np.abs(np.linalg.det(scene.whitening[rows])))
        view = ImageView(
            float(scene.principal_distance[image]), Pose(scene.rotation[image], scene.position[image]),
            scene.xy[rows], sigma, self.directions.angle[rows], self.directions.sigma[rows], self.rough,
            np.zeros(len(self.rough)), self.context.settings.direction_tolerance_rad,
            self.context.settings.wrong_share,
        )  # fmt: skip
        return self._with_samples(view, spread, float(np.median(sigma)) if len(sigma) else 0.0)

    def _with_samples(self, view: ImageView, spread: float, sigma: float) -> ImageView:
        """The view with samples of curves that come near its points."""
        near = _inside(view, REACH * spread + MARGIN * sigma)
        if not len(near):
            return self._with(view, view.samples.select(near))
        depth = float(np.median(np.linalg.norm(self.rough.xyz[near] - view.start.position, axis=1)))
        scale = depth / view.principal_distance
        coarsest = max(COARSEST * sigma, 0.5 * REACH * spread) * scale
        spacing = max(FINEST * sigma * scale, min(self.rough.spacing * len(near) / SAMPLES, coarsest))
        keep = np.zeros(len(self.scene.curves.bases), dtype=bool)
        keep[self.rough.curve[near]] = True
        samples = CurveSamples.of(self.scene.curves, self.scene.coefficients, keep, spacing)
        view = self._with(view, samples)
        reach = REACH * spread + MARGIN * sigma + spacing / scale
        return self._with(view, samples.select(_near_points(view, reach)))

    def _with(self, view: ImageView, samples: CurveSamples) -> ImageView:
        return replace(view, samples=samples, shape_sigma=narrow_shapes(self.context.start)[samples.curve])


def _inside(view: ImageView, margin: float) -> IntArray:
    """Samples inside the box of the points with a margin and, since it is wide where points are few, half its size."""
    xy: FloatArray = view.seen(view.start).xy
    reach = margin + 0.5 * float(np.ptp(view.xy, axis=0).max(initial=0.0))
    with np.errstate(invalid="ignore"):
        inside = (xy >= view.xy.min(axis=0) - reach) & (xy <= view.xy.max(axis=0) + reach)
    return np.flatnonzero(inside.all(axis=1))


def _near_points(view: ImageView, reach: float) -> IntArray:
    """Samples that are not farther than that from some point."""
    xy = view.seen(view.start).xy
    visible = np.flatnonzero(np.isfinite(xy).all(axis=1))
    distance, _ = cKDTree(view.xy).query(xy[visible], distance_upper_bound=reach)
    return visible[np.isfinite(distance)]
