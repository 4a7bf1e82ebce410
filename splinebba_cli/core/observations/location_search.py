"""Foot points searched globally: Newton's method from the nearest of many samples of the projected curve.

A point whose foot point from the present location is certainly the nearest is left alone (nearest_branch.py); of long
curves only the segments that an image can see near its points are sampled (nearby_segments.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.camera.collinearity import project
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.observations.linked_locations import in_better_chains, settle_linked
from splinebba_cli.core.observations.locations import location_bounds, refine_locations
from splinebba_cli.core.observations.nearby_segments import nearby_segments
from splinebba_cli.core.observations.nearest_branch import surely_nearest
from splinebba_cli.core.row_groups import RowGroups
from splinebba_cli.core.state import Prepared, State

SAMPLES_PER_SEGMENT = 16


def search_locations(prepared: Prepared, state: State) -> State:
    """Foot points nearest to the measured points; never worse than from the present locations (NaN: unknown)."""
    observed = prepared.network.curve_observations
    if not len(observed):
        return state
    known = np.isfinite(state.location)
    before = state
    if known.any():
        middle = 0.5 * (prepared.curves.first + prepared.curves.last)[observed.curve]
        begin = replace(state, location=np.where(known, state.location, middle))
        before = refine_locations(prepared, begin, only=known)
        doubtful = ~(known & surely_nearest(prepared, before))
    else:
        doubtful = np.ones(len(observed), dtype=bool)
    if not doubtful.any():
        return before
    points = np.flatnonzero(doubtful)
    before = _not_worse(prepared, state, before, points[known[points]])
    location = before.location.copy()
    location[points] = _nearest_samples(prepared, state, points)
    found = refine_locations(prepared, replace(state, location=location), only=doubtful)
    if not known.any():
        return found
    better = ~known
    better[points] |= _squares(prepared, found, points) < _squares(prepared, before, points) * (1.0 - 1e-9)
    if len(prepared.chains):
        before = settle_linked(prepared, before, *location_bounds(prepared))
        better = np.where(prepared.chains.linked, in_better_chains(prepared, found, before) | ~known, better)
    return replace(state, location=np.where(better, found.location, before.location))


def _not_worse(prepared: Prepared, given: State, refined: State, points: IntArray) -> State:
    """The refined locations, but where those of some points were better as given."""
    worse = points[_squares(prepared, given, points) < _squares(prepared, refined, points)]
    location = refined.location.copy()
    location[worse] = given.location[worse]
    return replace(refined, location=location)


def squared_distance(prepared: Prepared, state: State) -> FloatArray:
    """Whitened squared distance of every measured point to its curve point, (n,); inf behind a camera."""
    return _squares(prepared, state, np.arange(len(state.location)))


def _squares(prepared: Prepared, state: State, points: IntArray) -> FloatArray:
    """The same of some measured points, (k,)."""
    observed = prepared.network.curve_observations
    image, curve = observed.image[points], observed.curve[points]
    xyz = prepared.curves.evaluate(state.coefficients, curve, state.location[points])[0]
    xy = project(prepared.principal_distance[image], state.rotation[image], state.position[image], xyz)
    off = (xy - prepared.curve_rays.xy[points])[:, :, None]
    r = np.matmul(prepared.curve_rays.whitening[points], off)[:, :, 0]
    return np.where(np.isfinite(r).all(axis=1), np.sum(r * r, axis=1), np.inf)


def _nearest_samples(prepared: Prepared, state: State, points: IntArray) -> FloatArray:
    """Parameter of the nearest sample of the projected curve of some measured points, (k,)."""
    observed, curves = prepared.network.curve_observations, prepared.curves
    low, high = (bound[points] for bound in location_bounds(prepared))
    steps = (np.arange(SAMPLES_PER_SEGMENT) + 0.5) / SAMPLES_PER_SEGMENT
    groups = RowGroups.of(observed.image[points] * len(curves.bases) + observed.curve[points])
    pair = points[groups.representative]
    pair_image, pair_curve = observed.image[pair], observed.curve[pair]
    segments = nearby_segments(
        prepared, state, curves.segment_polynomials(state.coefficients), pair_image, pair_curve,
        *_circles(groups, prepared.curve_rays.xy[points]),
    )  # fmt: skip
    location = np.zeros(len(points) + 1)
    measured = np.concatenate([prepared.curve_rays.xy[points], np.zeros((1, 2))])
    whitening = np.concatenate([prepared.curve_rays.whitening[points], np.eye(2)[None]])
    round_errors = _are_round(whitening)
    bounds_low, bounds_high = np.append(low, -np.inf), np.append(high, np.inf)
    for chosen, rows in groups.batches(2 * SAMPLES_PER_SEGMENT * (segments >= 0).sum(axis=1)):
        image, own = pair_image[chosen], segments[chosen]
        own = own[:, : int((own >= 0).sum(axis=1).max())]
        u = curves.left[own][:, :, None] + steps * curves.length[own][:, :, None]
        u = np.where(own[:, :, None] >= 0, u, np.nan).reshape(len(own), -1)
        sampled = np.repeat(pair_curve[chosen], u.shape[1])
        xyz = curves.evaluate(state.coefficients, sampled, np.nan_to_num(u).ravel())[0]
        repeated = np.repeat(image, u.shape[1])
        xy = project(
            prepared.principal_distance[repeated], state.rotation[repeated], state.position[repeated], xyz
        ).reshape(*u.shape, 2)
        offset = xy[:, None] - measured[rows][:, :, None]
        if not round_errors:
            offset = np.einsum("glij,glmj->glmi", whitening[rows], offset)
        distance = offset[..., 0] ** 2 + offset[..., 1] ** 2
        allowed = (u[:, None, :] >= bounds_low[rows][:, :, None]) & (
            u[:, None, :] <= bounds_high[rows][:, :, None]
        )
        distance = np.where(allowed & np.isfinite(distance), distance, np.inf)
        nearest = np.argmin(distance, axis=2)
        location[rows] = np.take_along_axis(np.nan_to_num(u), nearest, axis=1)
    return location[:-1]


def _circles(groups: RowGroups, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Circles around the points (k, 2) of every group: centres (G, 2) and radii (G,)."""
    ordered, starts = xy[groups.order], groups.starts[:-1]
    low, high = np.minimum.reduceat(ordered, starts), np.maximum.reduceat(ordered, starts)
    return 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)


def _are_round(whitening: FloatArray) -> bool:
    """Whether all measured points have nearly circular error ellipses: plain distances find the same sample."""
    if not len(whitening):
        return True
    size = np.abs(whitening[:, 0, 0])
    uneven = np.abs(whitening[:, 0, 0] - whitening[:, 1, 1])
    skew = np.abs(whitening[:, 0, 1]) + np.abs(whitening[:, 1, 0])
    return bool((uneven + skew < 0.1 * size).all())
