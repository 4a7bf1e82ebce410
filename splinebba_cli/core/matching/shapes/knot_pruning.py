"""Knots that pay nothing taken out again: those that change the shape of a curve least.

Half of the knots of every curve are tried first, then fewer, as long as that fails.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.kept_corners import breaks_among
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.matching.shapes.knot_need import cheaper, costs
from splinebba_cli.core.network import Curve, FloatArray

ROUNDS = 24


def without_idle_knots(draft: Draft) -> Draft:
    """Curves from which every knot is gone whose price exceeds what it saves, adjusted."""
    many = np.array([_inner(curve) // 2 for curve in draft.curves])
    for _ in range(ROUNDS):
        many = np.minimum(many, [_inner(curve) for curve in draft.curves])
        if not many.any():
            break
        curves = [
            _reduced(curve, basis, draft.coefficients_of(k), int(many[k])) if many[k] else curve
            for k, (curve, basis) in enumerate(
                zip(draft.present_curves(), draft.prepared.curves.bases, strict=True)
            )
        ]
        trial = with_curves(draft, tuple(curves)).solved()
        better = (many > 0) & (costs(trial) < costs(draft))
        draft = cheaper(draft, trial, better)
        many = np.where(better, np.maximum(many, 1), many // 2)
    return draft


def _inner(curve: Curve) -> int:
    """How many knots may be taken out."""
    return max(len(curve.values) - len(curve.breaks) - (4 if curve.closed else 2), 0)


def _reduced(curve: Curve, basis: CurveBasis, coefficients: FloatArray, many: int) -> Curve:
    """A curve without the inner knots that it would miss least, no two of them neighbours."""
    last = len(curve.values) - (0 if curve.closed else 1)
    inner = [k for k in range(1, last) if k not in curve.breaks]
    moved = np.array([_shift(curve, basis, coefficients, k) for k in inner])
    gone: list[int] = []
    for place in np.argsort(moved, kind="stable").tolist():
        knot = inner[place]
        if len(gone) < many and not {knot - 1, knot + 1} & set(gone):
            gone.append(knot)
    return _without(curve, gone)


def _without(curve: Curve, knots: list[int]) -> Curve:
    before = np.asarray(curve.knot_parameters)
    parameters = np.delete(before, knots)
    values = np.delete(curve.values, knots, axis=0)
    breaks = breaks_among(parameters, before[list(curve.breaks)])
    return replace(
        curve, values=values, sigma=np.full_like(values, np.inf), knot_parameters=parameters, breaks=breaks
    )


def _shift(curve: Curve, basis: CurveBasis, coefficients: FloatArray, knot: int) -> float:
    """How far the curve moves at a knot when it is taken out."""
    less = _without(curve, [knot])
    other = natural_cubic_basis(np.asarray(less.knot_parameters), curve.closed, less.breaks)
    at = basis.break_points[[knot]]
    own = other.evaluate(at, other.coefficients_from_values(less.values))
    return float(np.linalg.norm(own - basis.evaluate(at, coefficients)))
