"""Knots that nothing supports: a segment with too few measured points is joined with a neighbour.

Without measurements from two images between them two knots slide and swing freely.  An end segment that nothing
supports is cut off.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.knot_spacing import present_curve, respaceable, restart
from splinebba_cli.core.network import Curve, FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State

FEWEST = 4  # measured points in a segment


def with_removed_knots(prepared: Prepared, state: State) -> tuple[Prepared, State] | None:
    """The network without unsupported knots; None where all are supported."""
    curves, measured = prepared.curves, prepared.network.curve_observations
    segment, _ = curves.locate(measured.curve, state.location)
    number = np.bincount(segment, minlength=len(curves.left))
    images = np.unique(np.stack([segment, measured.image]), axis=1)[0]
    number[np.bincount(images, minlength=len(curves.left)) < 2] = 0
    changed, any_change = [], False
    for k, curve in enumerate(prepared.network.curves):
        rows = slice(int(curves.segment_start[k]), int(curves.segment_start[k + 1]))
        own = state.coefficients[int(curves.coefficient_start[k]) : int(curves.coefficient_start[k + 1])]
        present = present_curve(prepared, k, own)
        if respaceable(curve):
            keep = supported_knots(number[rows], curve.closed)
            if len(keep) < len(present.values):
                present, any_change = _reduced(prepared, k, present, own, keep), True
        changed.append(present)
    return restart(prepared.network, tuple(changed), state) if any_change else None


def supported_knots(number: IntArray, closed: bool) -> IntArray:
    """Knots to keep so that every segment has enough measured points, by joining the poorest segments first.

    Parameters
    ----------
    number : (S,) measured points per segment
    """
    fewest_segments = 3 if closed else 1
    counts = list(number)
    knots = list(range(len(number) + (0 if closed else 1)))
    while len(counts) > fewest_segments and min(counts) < FEWEST:
        poor = int(np.argmin(counts))
        if not closed and counts[poor] == 0 and poor in (0, len(counts) - 1):
            del knots[0 if poor == 0 else -1], counts[poor]
            continue
        left, right = (poor - 1) % len(counts), (poor + 1) % len(counts)
        neighbours = [s for s in (left, right) if closed or abs(s - poor) == 1]
        other = min(neighbours, key=lambda s: counts[s])
        first, second = (poor, other) if (poor + 1) % len(counts) == other else (other, poor)
        del knots[second % len(knots)]  # the knot between them begins the second
        counts[first] += counts[second]
        del counts[second]
    return np.array(knots, dtype=np.int64)


def _reduced(prepared: Prepared, k: int, present: Curve, own: FloatArray, keep: IntArray) -> Curve:
    basis = prepared.curves.bases[k]
    parameters = basis.break_points[keep]
    if basis.closed:
        parameters = np.append(parameters, parameters[0] + basis.break_points[-1] - basis.break_points[0])
    knots = basis.evaluate(basis.break_points[keep], own)
    return replace(
        present, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None
    )
