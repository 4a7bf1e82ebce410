"""Knots that pay nothing taken out again: one of every curve at a time, the one that changes its shape least."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.matching.shapes.knot_need import cheaper, costs
from splinebba_cli.core.network import Curve, FloatArray

ROUNDS = 12


def without_idle_knots(draft: Draft) -> Draft:
    """Curves from which every knot is gone whose price exceeds what it saves, adjusted."""
    open_ = np.ones(len(draft.curves), dtype=bool)
    for _ in range(ROUNDS):
        curves, changed = [], np.zeros(len(draft.curves), dtype=bool)
        for k, curve in enumerate(draft.present_curves()):
            less = (
                _reduced(curve, draft.prepared.curves.bases[k], draft.coefficients_of(k))
                if open_[k]
                else None
            )
            curves.append(curve if less is None else less)
            changed[k] = less is not None
        if not changed.any():
            break
        trial = with_curves(draft, tuple(curves)).solved()
        better = changed & (costs(trial) < costs(draft))
        open_ = better
        draft = cheaper(draft, trial, better)
    return draft


def _reduced(curve: Curve, basis: CurveBasis, coefficients: FloatArray) -> Curve | None:
    """A curve without the inner knot that it would miss least; None where there is none."""
    inner = list(range(1, len(curve.values) - (0 if curve.closed else 1)))
    if not inner or (curve.closed and len(curve.values) <= 4):
        return None
    moved = [_shift(curve, basis, coefficients, k) for k in inner]
    return _without(curve, inner[int(np.argmin(moved))])


def _without(curve: Curve, knot: int) -> Curve:
    parameters = np.delete(np.asarray(curve.knot_parameters), knot)
    values = np.delete(curve.values, knot, axis=0)
    return replace(curve, values=values, sigma=np.full_like(values, np.inf), knot_parameters=parameters)


def _shift(curve: Curve, basis: CurveBasis, coefficients: FloatArray, knot: int) -> float:
    """How far the curve moves at a knot when it is taken out."""
    less = _without(curve, knot)
    other = natural_cubic_basis(np.asarray(less.knot_parameters), curve.closed)
    at = basis.break_points[[knot]]
    own = other.evaluate(at, other.coefficients_from_values(less.values))
    return float(np.linalg.norm(own - basis.evaluate(at, coefficients)))
