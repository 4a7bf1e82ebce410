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
from splinebba_cli.core.observations.corner_feet import at_corners, settle_at_corners
from splinebba_cli.core.observations.foot_points import LARGEST_STEP, LEFT_ERROR, foot_points_of_tracks
from splinebba_cli.core.observations.linked_locations import settle_linked
from splinebba_cli.core.observations.projected_places import newton_step
from splinebba_cli.core.speed import compiled_kernels
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.core.threads import in_threads

NEWTON_STEPS = 12
KERNELS = "splinebba_cli.core.observations.foot_points_compiled"
WORTHWHILE = 100_000  # points from which loading them pays


def location_bounds(prepared: Prepared) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest allowed location of every measured point, (n,) each."""
    return prepared.location_bounds


def held_locations(prepared: Prepared, location: FloatArray) -> IntArray:
    """Measured points whose location is at its bound or at a corner: they have no location unknown."""
    low, high = location_bounds(prepared)
    return np.flatnonzero((location <= low) | (location >= high) | at_corners(prepared, location))


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
    settle_at_corners(prepared, state, polynomials, free, location, steps)
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
        new, settled = newton_step(prepared, state, polynomials, active, location[active])
        new = np.clip(new, low[active], high[active])
        settled |= new == location[active]
        location[active] = new
        active = active[~settled]
