"""Rows of measured points over the orientation of their image and the coefficients under their segment.

    b = (d/dtheta, d/dX0, N_1 g, ..., N_w g),   g = R h

The equations of :mod:`~splinebba_cli.core.observations.curve_points`, computed with all points in the last axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.estimation.located_points import Located
from splinebba_cli.core.estimation.seen_points import SeenPoints
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.curve_point_rows import PointDirections
from splinebba_cli.core.observations.curve_points import UNSETTLED
from splinebba_cli.core.observations.photo_polynomials import photo_polynomials, places_on_segments
from splinebba_cli.core.state import Prepared


@dataclass(frozen=True)
class SegmentRows:
    """Equations of some measured points; row k belongs to the point with number ``point[k]`` among them."""

    point: IntArray  # (k,) 0 .. n - 1 across the curve, then those along it, ascending
    residual: FloatArray  # (k,) whitened
    normal: FloatArray  # (n, 2) whitened unit normal
    speed: FloatArray  # (n,) whitened residual per unit of u
    jacobian: FloatArray  # (k, 6 or 0 + 3 w), removed unknowns as well


def rows_on_segments(
    prepared: Prepared, at: Located, points: IntArray, along: BoolArray, orientation_size: int
) -> SegmentRows:
    """Equations of measured points on curves of powers.

    Parameters
    ----------
    points : (n,) int
    along : (n,) bool, points that get their equation along the curve as well; so do those whose location is no
        foot point, and none that is linked

    Raises
    ------
    FloatingPointError
        If a point of a curve lies behind a camera.
    """
    segment, t = at.segments(points)
    seen = _seen(prepared, at, points, segment, t)
    rays = prepared.rays_by_component[points]
    directions = PointDirections.of(seen.places, rays)
    wanted = (along | (np.abs(directions.along) > UNSETTLED)) & ~prepared.chains.linked[points]
    extra = np.flatnonzero(wanted)
    normal = np.stack([-directions.unit[1], directions.unit[0]])
    gradients = directions.gradients(rays, directions.unit)
    if len(extra) < len(points):
        gradients = gradients[:, extra]
    across = seen.rows(directions.gradients(rays, normal), directions.across, orientation_size)
    every = seen if len(extra) == len(points) else seen[extra]
    second = every.rows(gradients, directions.along[extra], orientation_size)
    both = np.empty((len(points) + len(extra), len(across)))
    both[: len(points)], both[len(points) :] = across.T, second.T
    return SegmentRows(
        point=np.concatenate([np.arange(len(points)), extra]),
        residual=both[:, -1],
        normal=np.ascontiguousarray(normal.T),
        speed=directions.speed / prepared.curves.length[segment],
        jacobian=both[:, :-1],
    )


def _seen(prepared: Prepared, at: Located, points: IntArray, segment: IntArray, t: FloatArray) -> SeenPoints:
    """Measured points as their images see them; the polynomials of one image and segment are rotated once."""
    curves, image = prepared.curves, prepared.network.curve_observations.image[points]
    distance = prepared.principal_distance
    keys, column = np.unique(image * len(curves.left) + segment, return_inverse=True)
    of_image, of_segment = np.divmod(keys, len(curves.left))
    table = photo_polynomials(at.polynomials, distance, at.state, of_image, of_segment[:, None])
    return SeenPoints(
        places=places_on_segments(table, column, t),
        weights=np.ascontiguousarray(curves.weights(segment, t).T),
        rotation=np.take(at.state.rotation.transpose(1, 2, 0), image, axis=2),
        distance=distance[image],
    )
