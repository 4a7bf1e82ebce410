"""Measuring what the images see: places on curves and points inside the format, without noise.

Every image measures a curve at its own places: no measured point is conjugate to one in another image.
The places depend on the block alone, noise and starts on the seed, so that Monte Carlo runs repeat one
design.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import BoolArray, CurveObservations, FloatArray, PointObservations
from splinebba_cli.simulation.truth import Shape

SAMPLES = 4001  # along a curve, to find what an image sees
LEAST_SHARE = 0.1  # an image that sees less of a curve does not measure it


class Views(Protocol):
    """What the images of a block see."""

    @property
    def image_count(self) -> int:
        """Number of images."""

    def photo_xy(self, image: int, xyz: FloatArray) -> FloatArray:
        """Exact measured coordinates (n, 2) mm of points (n, 3) in one image, NaN behind the camera."""

    def inside_format(self, image: int, photo_xy: FloatArray) -> BoolArray:
        """Whether measured coordinates lie inside the format, (n,)."""


def choose_locations(
    views: Views, image: int, shape: Shape, count: int, generator: np.random.Generator, least_share: float
) -> FloatArray:
    """Locations u (count,) at which an image measures a curve, ascending; none where it hardly sees it.

    One location is drawn from each of `count` equal shares of what lies inside the format.
    """
    basis, coefficients = shape
    u = np.linspace(basis.break_points[0], basis.break_points[-1], SAMPLES)
    seen = u[views.inside_format(image, views.photo_xy(image, basis.evaluate(u, coefficients)))]
    if not len(seen) or len(seen) < least_share * SAMPLES:
        return np.zeros(0)
    place = (np.arange(count) + generator.uniform(0.05, 0.95, count)) / count * (len(seen) - 1)
    lower = np.floor(place).astype(np.int64)
    gap = seen[np.minimum(lower + 1, len(seen) - 1)] - seen[lower]
    step = np.where(gap < 1.5 * (u[1] - u[0]), gap, 0.0)  # never between two separate parts
    return np.asarray(seen[lower] + (place - lower) * step)


def measure_curves(
    views: Views,
    curves: Sequence[tuple[CurveBasis, FloatArray]],
    count: int,
    generator: np.random.Generator,
    least_share: float = LEAST_SHARE,
) -> tuple[CurveObservations, FloatArray]:
    """Exact image points of curves (basis and coefficients), `count` for each image that sees one.

    Returns
    -------
    observations : CurveObservations
        Without noise and standard deviations; locations unknown.
    locations : (n,) float
    """
    none = np.zeros(0, dtype=np.int64)
    image, curve, u, xy = [none], [none], [np.zeros(0)], [np.zeros((0, 2))]
    for index, shape in enumerate(curves):
        for view in range(views.image_count):
            chosen = choose_locations(views, view, shape, count, generator, least_share)
            xy.append(views.photo_xy(view, shape[0].evaluate(chosen, shape[1])))
            u.append(chosen)
            image.append(np.full(len(chosen), view, dtype=np.int64))
            curve.append(np.full(len(chosen), index, dtype=np.int64))
    locations = np.concatenate(u)
    observations = CurveObservations(
        image=np.concatenate(image),
        curve=np.concatenate(curve),
        photo_xy=np.vstack(xy),
        sigma=np.full((len(locations), 2), np.nan),
        location=np.full(len(locations), np.nan),
        segment=np.full(len(locations), -1, dtype=np.int64),
    )
    return observations, locations


def measure_points(views: Views, xyz: FloatArray) -> PointObservations:
    """Exact image points of object points in every image that sees them; without standard deviations."""
    none = np.zeros(0, dtype=np.int64)
    image, point, xy = [none], [none], [np.zeros((0, 2))]
    for view in range(views.image_count):
        photo = views.photo_xy(view, xyz)
        seen = np.flatnonzero(views.inside_format(view, photo))
        image.append(np.full(len(seen), view, dtype=np.int64))
        point.append(seen.astype(np.int64))
        xy.append(photo[seen])
    whole = np.concatenate(point)
    return PointObservations(np.concatenate(image), whole, np.vstack(xy), np.full((len(whole), 2), np.nan))
