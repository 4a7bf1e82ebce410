"""Knots that nothing supports: a segment with too few measured points is joined with a neighbour.

Without measurements from two images between them two knots slide and swing freely.  An end segment that nothing
supports is cut off.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.approximation.knot_spacing import present_curve, respaceable, restart
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters, supported_knots_between
from splinebba_cli.core.curves.support import supported_knots
from splinebba_cli.core.network import Curve, FloatArray, IntArray
from splinebba_cli.core.state import Prepared, State


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
            keep = _supported(curve, number[rows])
            if len(keep) < len(present.values):
                present, any_change = _reduced(prepared, k, present, own, keep), True
        changed.append(present)
    return restart(prepared.network, tuple(changed), state) if any_change else None


def _supported(curve: Curve, number: IntArray) -> IntArray:
    """Knots to keep; a curve with corners is not cut at its ends."""
    if curve.breaks:
        return supported_knots_between(number, curve.breaks)
    return supported_knots(number, curve.closed)


def _reduced(prepared: Prepared, k: int, present: Curve, own: FloatArray, keep: IntArray) -> Curve:
    basis = prepared.curves.bases[k]
    parameters = basis.break_points[keep]
    if basis.closed:
        parameters = np.append(parameters, parameters[0] + basis.break_points[-1] - basis.break_points[0])
    knots = basis.evaluate(basis.break_points[keep], own)
    return replace(
        present, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None,
        breaks=breaks_among(parameters, corner_parameters(present, basis)),
    )  # fmt: skip
