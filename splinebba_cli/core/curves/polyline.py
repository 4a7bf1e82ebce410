"""A digitised polyline: points in their order with a parameter, repeated points taken out, corners found."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.errors import FitError

COINCIDING = 1e-9  # of the extent: closer points are the same


@dataclass(frozen=True)
class Polyline:
    """Distinct points with strictly ascending parameters."""

    points: FloatArray  # (n, 3) metres, reduced by `origin`
    parameters: FloatArray  # (n,) from 0
    end: float  # parameter of the last point; closed: of the first point, one turn later
    corners: FloatArray  # parameters of the corners
    closed: bool
    meets_itself: bool  # a closed one with corners, opened at the first of them
    origin: FloatArray  # (3,) metres
    given: IntArray  # (n,) number of every point in the input

    def thinned(self, step: int) -> Polyline:
        """Every step-th point, with both ends and the corners."""
        keep = np.isin(self.parameters, self.corners)
        keep[::step] = keep[-1] = True
        return replace(
            self, points=self.points[keep], parameters=self.parameters[keep], given=self.given[keep]
        )

    def at(self, parameters: FloatArray) -> FloatArray:
        """Points of the polyline at parameters, (m, 3)."""
        known, points = self.parameters, self.points
        if self.closed:
            known, points = np.append(known, self.end), np.vstack([points, points[:1]])
        return np.stack([np.interp(parameters, known, points[:, k]) for k in range(3)], axis=1)


def polyline_of(
    points: FloatArray,
    *,
    closed: bool = False,
    parameterization: Literal["chord_length", "uniform"] = "chord_length",
    corner_angle_deg: float | None = None,
) -> Polyline:
    """The polyline of digitised points.

    Parameters
    ----------
    points : (n, 3) float, metres
    closed : whether the last point is joined with the first one; a repeated first point is left out
    parameterization : cumulated chord length, metres, or one unit from point to point
    corner_angle_deg : a change of direction larger than this is a corner; None: there are none

    Raises
    ------
    FitError
        SBB320 for too few distinct points, SBB403 for what are no finite coordinates.
    """
    array = _checked(points)
    origin = np.round(array.mean(axis=0))
    array = array - origin
    keep = _distinct(array, closed)
    given, array = np.flatnonzero(keep), array[keep]
    fewest = 3 if closed else 2
    if len(array) < fewest:
        kind = "a closed curve needs three distinct points" if closed else "a curve needs two distinct points"
        raise FitError("SBB320", f"{kind}, not {len(array)}")
    corner = np.array([], dtype=np.int64)
    if corner_angle_deg is not None:
        corner = np.flatnonzero(turning_angles_deg(array, closed) > corner_angle_deg)
    meets_itself = closed and len(corner) > 0
    if meets_itself:
        order = (np.arange(len(array) + 1) + corner[0]) % len(array)
        given, array, corner = given[order], array[order], corner[1:] - corner[0]
        closed = False
    joined = np.vstack([array, array[:1]]) if closed else array
    steps = np.linalg.norm(np.diff(joined, axis=0), axis=1)
    if parameterization == "uniform":
        steps = np.ones(len(steps))
    cumulated = np.concatenate([[0.0], np.cumsum(steps)])
    return Polyline(
        points=array,
        parameters=cumulated[: len(array)],
        end=float(cumulated[-1]),
        corners=cumulated[corner],
        closed=closed,
        meets_itself=meets_itself,
        origin=origin,
        given=given,
    )


def turning_angles_deg(points: FloatArray, closed: bool) -> FloatArray:
    """Change of direction at every point of a polyline, degrees; 0 at the ends of an open one, (n,)."""
    joined = np.vstack([points[-1:], points, points[:1]]) if closed else points
    steps = np.diff(joined, axis=0)
    steps = steps / np.linalg.norm(steps, axis=1)[:, None]
    sine = np.linalg.norm(np.cross(steps[:-1], steps[1:]), axis=1)
    angle = np.degrees(np.arctan2(sine, np.sum(steps[:-1] * steps[1:], axis=1)))
    return angle if closed else np.concatenate([[0.0], angle, [0.0]])


def _checked(points: FloatArray) -> FloatArray:
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 3:
        raise FitError("SBB403", f"points are rows of x, y, z; the array has the shape {array.shape}")
    if not len(array):
        raise FitError("SBB320", "there are no points")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        more = f" (and {len(bad) - 1} more)" if len(bad) > 1 else ""
        raise FitError("SBB403", f"point {bad[0] + 1} has no finite coordinates{more}")
    return array


def _distinct(points: FloatArray, closed: bool) -> BoolArray:
    """Which points differ from the last one that is kept before them, (n,)."""
    tolerance = COINCIDING * float(np.ptp(points, axis=0).max())
    keep = np.ones(len(points), dtype=bool)
    last = 0
    close = np.linalg.norm(np.diff(points, axis=0), axis=1) <= tolerance
    if not close.any():
        last = len(points) - 1
    else:
        for number in range(1, len(points)):
            keep[number] = np.linalg.norm(points[number] - points[last]) > tolerance
            last = number if keep[number] else last
    while closed and last > 0 and np.linalg.norm(points[last] - points[0]) <= tolerance:
        keep[last] = False
        last = int(np.flatnonzero(keep)[-1])
    return keep
