"""Foot points: the location of every measured point, nearest to it on the projected curve.

Along the projected curve p(u), with whitened r(u) = W (p(u) - xy), the squared distance is stationary where
r . r' = 0; Newton's method uses the exact second derivative.  (theory, sections 3 and 8)
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.foot_points import LARGEST_STEP, LEFT_ERROR, foot_points_of_tracks
from splinebba_cli.core.observations.linked_locations import settle_linked
from splinebba_cli.core.speed import compiled_kernels
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.core.threads import in_threads

NEWTON_STEPS = 12
CHUNK = 8192  # points at once
KERNELS = "splinebba_cli.core.observations.foot_points_compiled"
WORTHWHILE = 100_000  # points from which loading them pays


def location_bounds(prepared: Prepared) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest allowed location of every measured point, (n,) each."""
    return prepared.location_bounds


def held_locations(prepared: Prepared, location: FloatArray) -> IntArray:
    """Measured points whose location is at its bound: they have no location unknown."""
    low, high = location_bounds(prepared)
    return np.flatnonzero((location <= low) | (location >= high))


def refine_locations(
    prepared: Prepared, state: State, steps: int = NEWTON_STEPS, only: BoolArray | None = None
) -> State:
    """Foot points by Newton's method from the present locations, all points at once; chains together.

    Parameters
    ----------
    only : (n,) bool, measured points to which this is restricted
    """
    low, high = location_bounds(prepared)
    curves, curve = prepared.curves, prepared.network.curve_observations.curve
    free = (low < high) & ~prepared.chains.linked
    if only is not None:
        free &= only
    polynomials = curves.segment_polynomials(state.coefficients)
    of_powers = free & ~curves.trigonometric[curves.segment_start[curve]] if len(curve) else free
    location, rest = state.location.copy(), [np.flatnonzero(free & ~of_powers)]
    powers = polynomials[:, :MAX_POWER]

    kernels = compiled_kernels(KERNELS, worthwhile=len(curve) >= WORTHWHILE)
    if kernels is not None:
        _walk_compiled(kernels, prepared, state, powers, of_powers, location, steps)
    else:
        rest.append(_walk(prepared, state, powers, of_powers, location, steps))
    _refine_one_by_one(prepared, state, polynomials, np.concatenate(rest), location, steps)
    return settle_linked(prepared, replace(state, location=curves.wrap(curve, location)), low, high)


def _walk(
    prepared: Prepared, state: State, polynomials: FloatArray, free: BoolArray, location: FloatArray, steps: int
) -> IntArray:  # fmt: skip
    """Foot points on curves of powers, in place; returns the points that are not finished."""

    def walk(tracks: slice) -> tuple[IntArray, FloatArray, BoolArray]:
        return foot_points_of_tracks(prepared, state, polynomials, tracks, free, steps)

    unfinished = [np.zeros(0, dtype=np.int64)]
    for points, found, lost in in_threads(walk, prepared.tracks.chunks()):
        location[points] = found
        unfinished.append(points[lost])
    return np.concatenate(unfinished)


def _walk_compiled(
    kernels: Any, prepared: Prepared, state: State, polynomials: FloatArray, free: BoolArray,
    location: FloatArray, steps: int,
) -> None:  # fmt: skip
    """The same by compiled kernels; none stays unfinished."""
    tracks, curves, (low, high) = prepared.tracks, prepared.curves, location_bounds(prepared)
    rays = prepared.curve_rays

    def walk(chunk: slice) -> None:
        kernels.walk_to_feet(
            chunk.start, chunk.stop, tracks.starts, tracks.image, tracks.curve, tracks.points, free, steps,
            LARGEST_STEP, LEFT_ERROR, location, low, high, polynomials, curves.left, curves.length,
            curves.segment_start, curves.first, curves.last, curves.closed, state.position, state.rotation,
            prepared.principal_distance, rays.xy, rays.whitening,
        )  # fmt: skip

    in_threads(walk, tracks.chunks())


def _refine_one_by_one(
    prepared: Prepared, state: State, polynomials: FloatArray, active: IntArray, location: FloatArray, steps: int
) -> None:  # fmt: skip
    """Foot points of some measured points on any curves, each with segment and photo of its own, in place."""
    low, high = location_bounds(prepared)
    for _ in range(steps):
        if not len(active):
            break
        new, settled = _newton_step(prepared, state, polynomials, active, location[active])
        new = np.clip(new, low[active], high[active])
        settled |= new == location[active]
        location[active] = new
        active = active[~settled]


def _newton_step(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """One safeguarded Newton step; whether each point has settled to rounding."""
    r, r1, r2, length = projected_derivatives(prepared, state, polynomials, rows, location)
    gradient, square = np.sum(r * r1, axis=1), np.sum(r1 * r1, axis=1)
    hessian = square + np.sum(r * r2, axis=1)
    curvature = np.where(hessian > 0.2 * square, hessian, square)
    step = -gradient / np.where(curvature > 0.0, curvature, 1.0)
    limit = length / 8.0
    step = np.clip(np.where(np.isfinite(step), step, 0.0), -limit, limit)
    return location + step, np.abs(step) * np.sqrt(square) < 1e-10


def projected_derivatives(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Whitened residual r = W (p(u) - xy), its first and second derivative d/du, and the length of the segments.

    Parameters
    ----------
    polynomials : (S, K, 3) of the present segments (:meth:`CurveSet.segment_polynomials`)
    rows : (k,) measured points
    location : (k,) their locations

    Returns
    -------
    r, r1, r2 : (k, 2) float
    length : (k,) float, in units of u
    """
    r, r1, r2 = (np.empty((len(rows), 2)) for _ in range(3))
    length = np.empty(len(rows))
    for begin in range(0, len(rows), CHUNK):
        part = slice(begin, begin + CHUNK)
        r[part], r1[part], r2[part], length[part] = _chunk_derivatives(
            prepared, state, polynomials, rows[part], location[part]
        )
    return r, r1, r2, length


def _chunk_derivatives(
    prepared: Prepared, state: State, polynomials: FloatArray, rows: IntArray, location: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """The same for as many points as stay in the cache; component by component."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    image = observed.image[rows]
    segment, t = curves.locate(observed.curve[rows], location)
    length = curves.length[segment]
    value, first, second = curves.derivatives(polynomials, segment, t)
    value -= state.position[image]
    rotation = state.rotation[image]
    p, p1, p2 = (
        [
            v[:, 0] * rotation[:, 0, k] + v[:, 1] * rotation[:, 1, k] + v[:, 2] * rotation[:, 2, k]
            for k in range(3)
        ]
        for v in (value, first, second)
    )
    inverse = 1.0 / p[2]
    scale = -prepared.principal_distance[image] * inverse
    xy = prepared.curve_rays.xy[rows]
    found = []
    for k in range(2):
        along = p[k] * inverse
        slope = p1[k] - along * p1[2]
        bend = p2[k] - along * p2[2] - 2.0 * slope * p1[2] * inverse
        found.append((scale * p[k] - xy[:, k], scale * slope, scale * bend))
    whitening = prepared.curve_rays.whitening[rows]
    r, r1, r2 = (
        np.stack([whitening[:, k, 0] * x + whitening[:, k, 1] * y for k in range(2)], axis=1)
        for x, y in zip(*found, strict=True)
    )
    return r, r1, r2, length
