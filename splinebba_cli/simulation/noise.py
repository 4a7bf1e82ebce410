"""Measuring a simulated block: what every image sees, with noise; and starts that are wrong.

Every image measures a curve at its own places: no measured point is conjugate to one in another image.
The places depend on the block alone, noise and starts on the seed, so that Monte Carlo runs repeat one
design.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.camera.rotation import rotation_object_from_photo
from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import BoolArray, CurveObservations, FloatArray, PointObservations
from splinebba_cli.simulation.block_geometry import BlockGeometry

SAMPLES = 4001  # along a curve, to find what an image sees
LEAST_SHARE = 0.1  # an image that sees less of a curve does not measure it


@dataclass(frozen=True)
class Noise:
    """How wrong measurements and starts are."""

    image_mm: float  # standard deviation of measured photo coordinates; 0: exact
    start_position_m: float  # largest error of an approximate coordinate of a perspective centre
    start_angle_rad: float  # largest error of an approximate angle
    start_knots_m: float  # largest error of an approximate coordinate of a knot


def photo_of(block: BlockGeometry, image: int, xyz: FloatArray) -> FloatArray:
    """Exact photo coordinates (n, 2) mm of points in one image, NaN behind the camera."""
    rotation = rotation_object_from_photo(block.eop[image, :3])
    return project(
        np.full(len(xyz), block.principal_distance_mm),
        np.broadcast_to(rotation, (len(xyz), 3, 3)),
        block.eop[image, None, 3:],
        xyz,
    )


def inside_format(block: BlockGeometry, photo_xy: FloatArray) -> BoolArray:
    """Whether photo coordinates lie inside the format, (n,)."""
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(photo_xy) <= 0.5 * np.asarray(block.format_mm)).all(axis=1))


def choose_locations(
    block: BlockGeometry,
    image: int,
    basis: CurveBasis,
    coefficients: FloatArray,
    count: int,
    generator: np.random.Generator,
) -> FloatArray:
    """Locations u (count,) at which an image measures a curve, ascending; none where it hardly sees it.

    One location is drawn from each of `count` equal shares of what lies inside the format.
    """
    u = np.linspace(basis.break_points[0], basis.break_points[-1], SAMPLES)
    seen = u[inside_format(block, photo_of(block, image, basis.evaluate(u, coefficients)))]
    if len(seen) < LEAST_SHARE * SAMPLES:
        return np.zeros(0)
    place = (np.arange(count) + generator.uniform(0.05, 0.95, count)) / count * (len(seen) - 1)
    lower = np.floor(place).astype(np.int64)
    gap = seen[np.minimum(lower + 1, len(seen) - 1)] - seen[lower]
    step = np.where(gap < 1.5 * (u[1] - u[0]), gap, 0.0)  # never between two separate parts
    return np.asarray(seen[lower] + (place - lower) * step)


def measure_curves(
    block: BlockGeometry,
    curves: list[tuple[CurveBasis, FloatArray]],
    count: int,
    generator: np.random.Generator,
) -> tuple[CurveObservations, FloatArray]:
    """Exact image points of curves (basis and coefficients), `count` for each image that sees one.

    Returns
    -------
    observations : CurveObservations
        Without noise and standard deviations; locations unknown.
    locations : (n,) float
    """
    image, curve, u, xy = [], [], [], []
    for index, (basis, coefficients) in enumerate(curves):
        for view in range(len(block.eop)):
            chosen = choose_locations(block, view, basis, coefficients, count, generator)
            xy.append(photo_of(block, view, basis.evaluate(chosen, coefficients)))
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


def measure_points(block: BlockGeometry, xyz: FloatArray) -> PointObservations:
    """Exact image points of object points in every image that sees them; without standard deviations."""
    image, point, xy = [], [], []
    for view in range(len(block.eop)):
        photo = photo_of(block, view, xyz)
        seen = np.flatnonzero(inside_format(block, photo))
        image.append(np.full(len(seen), view, dtype=np.int64))
        point.append(seen.astype(np.int64))
        xy.append(photo[seen])
    whole = np.concatenate(point)
    return PointObservations(np.concatenate(image), whole, np.vstack(xy), np.full((len(whole), 2), np.nan))


def perturbed(values: FloatArray, largest: float, generator: np.random.Generator) -> FloatArray:
    """Values with independent errors, equally likely up to ± `largest`."""
    return np.asarray(values + largest * generator.uniform(-1.0, 1.0, values.shape))
