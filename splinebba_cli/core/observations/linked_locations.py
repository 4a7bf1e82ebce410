"""Locations of linked points: all of a chain together, by Gauss-Newton steps of its tridiagonal system.

The sum of squares of a chain (image points, arc lengths, tangents) is minimised over its locations, orientations and
curves held.  A step is halved until its own chain gains by it; chains that have settled are left alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.chains import Chains
from splinebba_cli.core.network import BoolArray, FloatArray
from splinebba_cli.core.observations.along_curve import along_rows
from splinebba_cli.core.observations.arc_lengths import arc_residuals_and_slopes
from splinebba_cli.core.observations.chain_elimination import ChainRows, eliminate_chains
from splinebba_cli.core.observations.tangents import linearize_tangents
from splinebba_cli.core.state import Prepared, State

STEPS = 30
HALVINGS = 8
SETTLED = 1e-8  # step in sigma along the curve
SURE = 1e-3  # of sigma: a step that is taken without a look at what it gains
LARGEST_STEP = 0.25  # of a segment


def settle_linked(prepared: Prepared, state: State, low: FloatArray, high: FloatArray) -> State:
    """Locations of all chains at their joint minimum, from the present ones.

    Parameters
    ----------
    low, high : (n,) bounds of the locations
    """
    active, location = prepared.chains, state.location.copy()
    for _ in range(STEPS):
        if not len(active):
            break
        current = replace(state, location=location)
        try:
            step, size = _steps(prepared, current, active, low, high)
        except FloatingPointError:
            break
        sure = size.max(axis=1) < SURE
        factor = np.where(
            sure, 1.0, _gaining(prepared, current, active.select(~sure), step[~sure], low, high, sure)
        )
        _move(location, active, factor[:, None] * step, low, high)
        active = active.select((size.max(axis=1) >= SETTLED) & (factor > 0.0))
    return replace(state, location=prepared.curves.wrap(prepared.network.curve_observations.curve, location))


def _move(location: FloatArray, chains: Chains, step: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """Add steps to the locations of chains, in place, inside their bounds."""
    used = chains.points >= 0
    point = chains.points[used]
    location[point] = np.clip(location[point] + step[used], low[point], high[point])


def _gaining(
    prepared: Prepared, state: State, chains: Chains, step: FloatArray, low: FloatArray, high: FloatArray,
    elsewhere: BoolArray,
) -> FloatArray:  # fmt: skip
    """Factor of the step of every chain that makes it gain, 0 where none does; 1 where `elsewhere` is true."""
    out = np.ones(len(elsewhere))
    factor = np.ones(len(chains))
    before = chain_costs(prepared, state, chains)
    for _ in range(HALVINGS if len(chains) else 0):
        trial = state.location.copy()
        _move(trial, chains, factor[:, None] * step, low, high)
        worse = ~(chain_costs(prepared, replace(state, location=trial), chains) <= before)
        if not worse.any():
            break
        factor = np.where(worse, 0.5 * factor, factor)
    else:
        factor = np.where(worse, 0.0, factor) if len(chains) else factor
    out[~elsewhere] = factor
    return out


def chain_costs(prepared: Prepared, state: State, chains: Chains) -> FloatArray:
    """Sum of squares of each chain, across the curve included, (G,); inf where part lies behind a camera."""
    used, has_arc, has_tangent = chains.points >= 0, chains.arcs >= 0, chains.tangents >= 0
    points, arcs, tangents = np.zeros(used.shape), np.zeros(has_arc.shape), np.zeros(used.shape)
    try:
        points[used] = along_rows(prepared, state, chains.points[used]).square
        arcs[has_arc] = arc_residuals_and_slopes(prepared, state, chains.arcs[has_arc])[0] ** 2
        tangents[has_tangent] = (
            linearize_tangents(prepared, state, chains.tangents[has_tangent]).residual ** 2
        )
    except FloatingPointError:
        return np.full(len(chains), np.inf)
    return np.asarray(points.sum(axis=1) + arcs.sum(axis=1) + tangents.sum(axis=1))


def in_better_chains(prepared: Prepared, found: State, before: State) -> BoolArray:
    """Whether each measured point is in a chain that fits better in `found` than in `before`, (n,)."""
    chains = prepared.chains
    better = chain_costs(prepared, found, chains) < chain_costs(prepared, before, chains) * (1.0 - 1e-9)
    out = np.zeros(len(found.location), dtype=bool)
    used = chains.points >= 0
    out[chains.points[used]] = np.broadcast_to(better[:, None], chains.points.shape)[used]
    return out


def _steps(
    prepared: Prepared, state: State, chains: Chains, low: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Steps of the locations (G, L), and their size in sigma along the curve.

    A location at its bound whose step points outwards is held there while the others of its chain move.
    """
    free = low < high
    step, speed = _free_steps(prepared, state, chains, free)
    used = chains.points >= 0
    point = chains.points[used]
    at_bound = ((state.location <= low)[point] & (step[used] < 0.0)) | (
        (state.location >= high)[point] & (step[used] > 0.0)
    )
    if at_bound.any():
        free = free.copy()
        free[point[at_bound]] = False
        step, speed = _free_steps(prepared, state, chains, free)
    return step, np.abs(step) * speed


def _free_steps(
    prepared: Prepared, state: State, chains: Chains, free: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Steps of free locations and the speed along the curve in sigma per unit of u, (G, L)."""
    network, shape = prepared.network, chains.points.shape
    used, has_arc, has_tangent = chains.points >= 0, chains.arcs >= 0, chains.tangents >= 0
    rows = ChainRows(
        along=np.zeros((*shape, 1)),
        along_slope=np.zeros(shape),
        tangent=np.zeros((*shape, 1)),
        tangent_slope=np.zeros(shape),
        arc=np.zeros((shape[0], shape[1] - 1, 1)),
        arc_slopes=np.zeros((shape[0], shape[1] - 1, 2)),
    )
    point, arc, tangent = chains.points[used], chains.arcs[has_arc], chains.tangents[has_tangent]
    along = along_rows(prepared, state, point)
    rows.along[used, 0], rows.along_slope[used] = along.residual, along.slope * free[point]
    at_points = linearize_tangents(prepared, state, tangent)
    rows.tangent[has_tangent, 0] = at_points.residual
    rows.tangent_slope[has_tangent] = at_points.slope * free[network.tangents.point[tangent]]
    rows.arc[has_arc, 0], slopes = arc_residuals_and_slopes(prepared, state, arc)
    ends = np.stack([free[network.arc_lengths.first[arc]], free[network.arc_lengths.second[arc]]], axis=1)
    rows.arc_slopes[has_arc] = slopes * ends
    limit, speed = np.zeros(shape), np.zeros(shape)
    limit[used], speed[used] = LARGEST_STEP * prepared.curves.length[along.segment], along.slope
    return np.clip(eliminate_chains(rows).steps(), -limit, limit), speed
