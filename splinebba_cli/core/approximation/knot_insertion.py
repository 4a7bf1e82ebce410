"""Knots where the residuals ask for them (Lee 2.3.1: insert a knot where the fit is worst).

A segment whose residuals across are much larger than their declared sigma, or than those of its curve where these are
smaller, cannot follow the measurements; it is divided at the median of its measured points, where both parts keep
enough of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.knot_spacing import present_curve, respaceable, restart
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters
from splinebba_cli.core.network import BoolArray, Curve, FloatArray
from splinebba_cli.core.observations.curve_points import linearize_curve_points
from splinebba_cli.core.observations.locations import held_locations
from splinebba_cli.core.state import Prepared, State

EXCESS = 1.3  # of the declared sigma, or of the rms of the curve where that is smaller
FEWEST = 10  # measured points in a segment that may be divided
SHORTEST = 0.25  # of the mean segment of the curve


def with_inserted_knots(prepared: Prepared, state: State) -> tuple[Prepared, State] | None:
    """The network with divided segments where residuals are systematic; None where there are none."""
    curves = prepared.curves
    held = held_locations(prepared, state.location)
    rows = linearize_curve_points(prepared, state, held)
    count = len(prepared.network.curve_observations)
    segments = len(curves.left)
    square = np.bincount(rows.segment[:count], rows.residual[:count] ** 2, minlength=segments)
    number = np.bincount(rows.segment[:count], minlength=segments)
    rms = np.sqrt(square / np.maximum(number, 1))
    curve_of = np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start))
    total = np.sqrt(
        np.bincount(curve_of, square) / np.maximum(np.bincount(curve_of, number.astype(float)), 1)
    )
    mean_length = (np.bincount(curve_of, curves.length) / np.bincount(curve_of))[curve_of]
    halved = (
        (rms > EXCESS * np.minimum(total, 1.0)[curve_of])
        & (number >= FEWEST)
        & (curves.length > SHORTEST * mean_length)
    )
    halved &= np.array([respaceable(curve) for curve in prepared.network.curves], dtype=bool)[curve_of]
    if not halved.any():
        return None
    changed = []
    for k in range(len(curves.bases)):
        start, stop = int(curves.segment_start[k]), int(curves.segment_start[k + 1])
        own = state.coefficients[int(curves.coefficient_start[k]) : int(curves.coefficient_start[k + 1])]
        measured = state.location[prepared.network.curve_observations.curve == k]
        changed.append(_divided(prepared, k, own, halved[start:stop], measured))
    return restart(prepared.network, tuple(changed), state)


def _divided(prepared: Prepared, k: int, own: FloatArray, chosen: BoolArray, located: FloatArray) -> Curve:
    curve, basis = present_curve(prepared, k, own), prepared.curves.bases[k]
    if not chosen.any():
        return curve
    breaks = basis.break_points
    segment, _ = basis.locate(located)
    new = [float(np.median(located[segment == s])) for s in np.flatnonzero(chosen)]
    parameters = np.sort(np.concatenate([breaks, new]))
    apart = np.diff(parameters, prepend=-np.inf) > 1e-3 * (breaks[-1] - breaks[0])
    parameters = parameters[apart]
    knots = basis.evaluate(parameters[:-1] if basis.closed else parameters, own)
    return replace(
        curve, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None,
        breaks=breaks_among(parameters, corner_parameters(curve, basis)),
    )  # fmt: skip
