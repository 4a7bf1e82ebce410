"""Foot points: the location of every measured point, nearest to it on the projected curve.

Along the projected curve p(u), with whitened r(u) = W (p(u) - xy), the squared distance is stationary where
r . r' = 0; Newton's method uses the exact second derivative.  The global search starts it from the nearest of many
samples of the projected curve.  (theory, sections 3 and 8)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.observations.foot_points import foot_points_of_tracks
from splinebba_cli.core.observations.linked_locations import in_better_chains, settle_linked
from splinebba_cli.core.row_groups import RowGroups
from splinebba_cli.core.state import Prepared, State
from splinebba_cli.core.threads import in_threads

SAMPLES_PER_SEGMENT = 16
NEWTON_STEPS = 12
CHUNK = 8192  # points at once


def location_bounds(prepared: Prepared) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest allowed location of every measured point, (n,) each."""
    return prepared.location_bounds


def held_locations(prepared: Prepared, location: FloatArray) -> IntArray:
    """Measured points whose location is at its bound: they have no location unknown."""
    low, high = location_bounds(prepared)
    return np.flatnonzero((location <= low) | (location >= high))


def refine_locations(prepared: Prepared, state: State, steps: int = NEWTON_STEPS) -> State:
    """Foot points by Newton's method from the present locations, all points at once; chains together."""
    low, high = location_bounds(prepared)
    curves, curve = prepared.curves, prepared.network.curve_observations.curve
    free = (low < high) & ~prepared.chains.linked
    polynomials = curves.segment_polynomials(state.coefficients)
    of_powers = free & ~curves.trigonometric[curves.segment_start[curve]] if len(curve) else free
    location, rest = state.location.copy(), [np.flatnonzero(free & ~of_powers)]
    powers = polynomials[:, :MAX_POWER]

    def walk(tracks: slice) -> tuple[IntArray, FloatArray, BoolArray]:
        return foot_points_of_tracks(prepared, state, powers, tracks, of_powers, steps)

    for points, found, lost in in_threads(walk, prepared.tracks.chunks()):
        location[points] = found
        rest.append(points[lost])
    _refine_one_by_one(prepared, state, polynomials, np.concatenate(rest), location, steps)
    return settle_linked(prepared, replace(state, location=curves.wrap(curve, location)), low, high)


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


def search_locations(prepared: Prepared, state: State) -> State:
    """Foot points searched globally: the nearest sample of the projected curve, refined; never worse than before."""
    observed = prepared.network.curve_observations
    if not len(observed):
        return state
    start = replace(state, location=_nearest_samples(prepared, state))
    found = refine_locations(prepared, start)
    known = np.isfinite(state.location)
    if not known.any():
        return found
    before = replace(state, location=np.where(known, state.location, found.location))
    better = squared_distance(prepared, found) < squared_distance(prepared, before) * (1.0 - 1e-9)
    if len(prepared.chains):
        before = settle_linked(prepared, before, *location_bounds(prepared))
        better = np.where(prepared.chains.linked, in_better_chains(prepared, found, before), better)
    return replace(state, location=np.where(better | ~known, found.location, before.location))


def squared_distance(prepared: Prepared, state: State) -> FloatArray:
    """Whitened squared distance of every measured point to its curve point, (n,); inf behind a camera."""
    observed = prepared.network.curve_observations
    xyz = prepared.curves.evaluate(state.coefficients, observed.curve, state.location)[0]
    image = observed.image
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    r = np.matmul(prepared.curve_rays.whitening, (xy - prepared.curve_rays.xy)[:, :, None])[:, :, 0]
    return np.where(np.isfinite(r).all(axis=1), np.sum(r * r, axis=1), np.inf)


def _nearest_samples(prepared: Prepared, state: State) -> FloatArray:
    """Parameter of the nearest sample of the projected curve, (n,)."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    low, high = location_bounds(prepared)
    steps = (np.arange(SAMPLES_PER_SEGMENT) + 0.5) / SAMPLES_PER_SEGMENT
    sample_u = (curves.left[:, None] + steps * curves.length[:, None]).ravel()
    sample_curve = np.repeat(
        np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start)), SAMPLES_PER_SEGMENT
    )
    sample_xyz = curves.evaluate(state.coefficients, sample_curve, sample_u)[0]
    starts = curves.segment_start * SAMPLES_PER_SEGMENT
    groups = RowGroups.of(observed.image * len(curves.bases) + observed.curve)
    pair_image, pair_curve = observed.image[groups.representative], observed.curve[groups.representative]
    location = np.zeros(len(observed) + 1)
    measured = np.concatenate([prepared.curve_rays.xy, np.zeros((1, 2))])
    whitening = np.concatenate([prepared.curve_rays.whitening, np.eye(2)[None]])
    round_errors = _are_round(prepared.curve_rays.whitening)
    bounds_low, bounds_high = np.append(low, -np.inf), np.append(high, np.inf)
    widest = int(np.diff(starts).max(initial=1))
    for chosen, rows in groups.batches(2 * widest):
        image, curve = pair_image[chosen], pair_curve[chosen]
        counts = starts[curve + 1] - starts[curve]
        place = np.minimum(np.arange(counts.max()), counts[:, None] - 1) + starts[curve][:, None]
        xyz = sample_xyz[place].reshape(-1, 3)
        repeated = np.repeat(image, place.shape[1])
        xy = project(
            prepared.principal_distance[repeated], state.rotation[repeated], state.position[repeated], xyz
        ).reshape(*place.shape, 2)
        u = sample_u[place]
        offset = xy[:, None] - measured[rows][:, :, None]
        if not round_errors:
            offset = np.einsum("glij,glmj->glmi", whitening[rows], offset)
        distance = offset[..., 0] ** 2 + offset[..., 1] ** 2
        allowed = (u[:, None, :] >= bounds_low[rows][:, :, None]) & (
            u[:, None, :] <= bounds_high[rows][:, :, None]
        )
        distance = np.where(allowed & np.isfinite(distance), distance, np.inf)
        nearest = np.argmin(distance, axis=2)
        location[rows] = np.take_along_axis(u, nearest, axis=1)
    return location[:-1]


def _are_round(whitening: FloatArray) -> bool:
    """Whether all measured points have nearly circular error ellipses: plain distances find the same sample."""
    if not len(whitening):
        return True
    size = np.abs(whitening[:, 0, 0])
    uneven = np.abs(whitening[:, 0, 0] - whitening[:, 1, 1])
    skew = np.abs(whitening[:, 0, 1]) + np.abs(whitening[:, 1, 0])
    return bool((uneven + skew < 0.1 * size).all())
