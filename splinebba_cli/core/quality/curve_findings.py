"""What is wrong with the shape of adjusted curves: folds, and segments that nothing supports."""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.estimation.curve_folding import folded_segments
from splinebba_cli.core.result import Problem
from splinebba_cli.core.state import Prepared, State


def curve_findings(prepared: Prepared, state: State) -> tuple[Problem, ...]:
    """Problems of the curves that take part with free coefficients."""
    free = [bool(np.isinf(curve.sigma).all()) for curve in prepared.network.curves]
    return (*_folded(prepared, state, free), *_unsupported(prepared, state, free))


def _folded(prepared: Prepared, state: State, free: list[bool]) -> list[Problem]:
    folds = folded_segments(prepared, state.coefficients)
    return [
        Problem(
            "SBB535",
            "warning",
            f"spline `{curve.id}` turns back on itself between two knots",
            f"spline `{curve.id}`",
            "its knots are too dense for its measurements: use fewer of them, "
            "`adjustment: {knots: {spacing_m: …, drop: true}}`",
        )
        for curve, count, is_free in zip(prepared.network.curves, folds, free, strict=True)
        if count and is_free
    ]


def _unsupported(prepared: Prepared, state: State, free: list[bool]) -> list[Problem]:
    curves, measured = prepared.curves, prepared.network.curve_observations
    segment, _ = curves.locate(measured.curve, state.location)
    number = np.bincount(segment, minlength=len(curves.left))
    empty = np.flatnonzero(number == 0)
    curve_of = np.searchsorted(curves.segment_start, empty, side="right") - 1
    found = []
    for k in np.unique(curve_of).tolist():
        first, last = curves.segment_start[k : k + 2].tolist()
        if not free[k] or not number[first:last].any() or curves.bases[k].trigonometric:
            continue
        own = (empty[slice(*np.searchsorted(empty, [first, last]))] - first).tolist()
        places = ", ".join(f"{s}-{s + 1}" for s in own[:5]) + (" …" if len(own) > 5 else "")
        name = prepared.network.curves[k].id
        found.append(
            Problem(
                "SBB536",
                "warning",
                f"spline `{name}`: no measured point lies between knots {places}",
                f"spline `{name}`",
                "measure there, remove a knot, or let the program do it: `adjustment: {knots: {drop: true}}`",
            )
        )
    return found
