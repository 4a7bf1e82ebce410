"""Knots where the residuals of an image run along a curve for more than chance: inserted, and kept if they pay.

    |mean of NEIGHBOURS residuals of one image, one after another along the curve| sqrt(NEIGHBOURS) > tolerance

in sigma asks for a knot in their segment (Lee 2008, 2.3.1: where the largest distance exceeds the threshold).  A
knot has two directions across the curve; it stays if v'Pv falls by more than PRICE, what chance allows with
probability 0.05.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.matching.shapes.soundness import distorted, with_supported_knots
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray

PRICE = float(chi2.ppf(0.95, 2))
NEIGHBOURS = 5
FEWEST = 8  # links on either side of a new knot
ROUNDS = 8
LARGEST = 5.0  # sigma: a residual counts as at most this


def with_needed_knots(draft: Draft, tolerance: float) -> Draft:
    """Curves with knots inserted as long as that pays, adjusted.

    Parameters
    ----------
    tolerance : in sigma of the mean of neighbouring residuals
    """
    draft = with_supported_knots(draft).solved()
    open_ = np.ones(len(draft.curves), dtype=bool)
    for number in range(ROUNDS):
        new = wanted_knots(draft, tolerance, only=open_, most=None if number < 2 else 1)
        if not any(len(knots) for knots in new):
            break
        trial = with_curves(draft, _divided(draft, new)).solved()
        better = costs(trial) < costs(draft)
        open_ = np.array([len(knots) > 0 for knots in new]) & (better | (number < 2))
        draft = cheaper(draft, trial, better)
    return draft


def costs(draft: Draft) -> FloatArray:
    """v'Pv of every curve with the price of its knots, (nc,); a distorted curve costs infinitely much."""
    residual = np.clip(draft.equations().residual[: len(draft.row)], -LARGEST, LARGEST)
    count = len(draft.curves)
    found = np.bincount(draft.links.curve, residual**2, minlength=count)
    knots = np.diff(draft.prepared.curves.coefficient_start)
    return np.asarray(np.where(distorted(draft), np.inf, found + PRICE * knots))


def wanted_knots(draft: Draft, tolerance: float, only: BoolArray, most: int | None) -> list[FloatArray]:
    """New knot parameters of every curve.

    Parameters
    ----------
    only : (nc,) curves that are looked at
    most : new knots of one curve, the worst segments first; None: all that are wanted
    """
    residual = np.clip(draft.equations().residual[: len(draft.row)], -LARGEST, LARGEST)
    excess, place = running_means(draft, residual)
    curves, link = draft.prepared.curves, draft.links
    segment = curves.locate(link.curve, draft.state.location)[0]
    worst = np.zeros(len(curves.left))
    np.maximum.at(worst, segment[place], excess)
    found: list[FloatArray] = []
    for k in range(len(draft.curves)):
        start, stop = int(curves.segment_start[k]), int(curves.segment_start[k + 1])
        chosen = (
            start + np.flatnonzero(worst[start:stop] > tolerance) if only[k] else np.zeros(0, dtype=np.int64)
        )
        chosen = chosen[np.argsort(-worst[chosen], kind="stable")]
        new: list[float] = []
        for s in chosen.tolist():
            own = np.sort(draft.state.location[segment == s])
            if len(own) >= 2 * FEWEST and (most is None or len(new) < most):
                new.append(float(np.median(own)))
        found.append(_apart(np.array(new), curves.bases[k]))
    return found


def running_means(draft: Draft, residual: FloatArray) -> tuple[FloatArray, IntArray]:
    """Means of neighbouring residuals of one image on one curve over their sigma, and the links in their middle."""
    link = draft.links
    order = np.lexsort((draft.state.location, link.image, link.curve))
    key = link.curve[order] * (int(link.image.max(initial=0)) + 1) + link.image[order]
    if len(order) < NEIGHBOURS:
        return np.zeros(0), np.zeros(0, dtype=np.int64)
    total = np.concatenate([[0.0], np.cumsum(residual[order])])
    mean = (total[NEIGHBOURS:] - total[:-NEIGHBOURS]) / np.sqrt(NEIGHBOURS)
    whole = key[NEIGHBOURS - 1 :] == key[: len(key) - NEIGHBOURS + 1]
    middle = order[NEIGHBOURS // 2 : len(order) - NEIGHBOURS // 2]
    return np.abs(mean[whole]), middle[whole]


def _apart(new: FloatArray, basis: CurveBasis) -> FloatArray:
    """New knots that are not on top of others."""
    breaks = basis.break_points
    distance = np.abs(new[:, None] - breaks).min(axis=1, initial=np.inf)
    return np.asarray(new[distance > 1e-3 * (breaks[-1] - breaks[0])])


def _divided(draft: Draft, new: list[FloatArray]) -> tuple[Curve, ...]:
    return tuple(
        with_knots(curve, basis, draft.coefficients_of(k), own)
        for k, (curve, basis, own) in enumerate(
            zip(draft.present_curves(), draft.prepared.curves.bases, new, strict=True)
        )
    )


def with_knots(curve: Curve, basis: CurveBasis, coefficients: FloatArray, new: FloatArray) -> Curve:
    """A natural spline with more knots."""
    if not len(new):
        return curve
    breaks = basis.break_points
    parameters = np.sort(np.concatenate([breaks, new]))
    knots = basis.evaluate(parameters[:-1] if basis.closed else parameters, coefficients)
    return replace(
        curve, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None,
        breaks=breaks_among(parameters, corner_parameters(curve, basis)),
    )  # fmt: skip


def cheaper(draft: Draft, trial: Draft, better: BoolArray) -> Draft:
    """The better of two drafts for every curve; both have the same links."""
    if better.all():
        return trial
    pairs = zip(trial.present_curves(), draft.present_curves(), better, strict=True)
    curves = tuple(new if take else old for new, old, take in pairs)
    found = with_curves(draft, curves)
    location = np.where(better[draft.links.curve], trial.state.location, draft.state.location)
    return replace(found, state=replace(found.state, location=location))
