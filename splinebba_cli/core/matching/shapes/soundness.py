"""Curves that keep their shape: knots that slide along and fold the curve, and knots that nothing supports.

Locations of new curves are metres along them, so that |X'| is near 1 as long as knots stay where they are.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters, supported_knots_between
from splinebba_cli.core.curves.support import supported_knots
from splinebba_cli.core.estimation.curve_folding import folded_segments
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.network import BoolArray, Curve, FloatArray, IntArray

SLOWEST, FASTEST = 0.4, 2.5  # |X'|, typical of a segment
SAMPLES = np.linspace(0.05, 0.95, 7)


def distorted(draft: Draft) -> BoolArray:
    """Curves that fold, or whose knots have slid far, (nc,)."""
    curves = draft.prepared.curves
    polynomials = curves.segment_polynomials(draft.state.coefficients)
    segment = np.repeat(np.arange(len(curves.left)), len(SAMPLES))
    t = np.tile(SAMPLES, len(curves.left))
    speed = np.linalg.norm(curves.derivatives(polynomials, segment, t)[1], axis=1).reshape(-1, len(SAMPLES))
    typical = np.median(speed, axis=1)
    bad = (typical < SLOWEST) | (typical > FASTEST)
    curve = np.repeat(np.arange(len(curves.bases)), np.diff(curves.segment_start))
    slid = np.bincount(curve[bad], minlength=len(curves.bases)) > 0
    return np.asarray(slid | (folded_segments(draft.prepared, draft.state.coefficients) > 0))


def with_supported_knots(draft: Draft) -> Draft:
    """Curves without knots between which too few links, or those of one image only, lie."""
    if not draft.curves:
        return draft
    curves, links = draft.prepared.curves, draft.links
    segment = curves.locate(links.curve, draft.state.location)[0]
    number = np.bincount(segment, minlength=len(curves.left))
    images = np.unique(np.stack([segment, links.image]), axis=1)[0]
    number[np.bincount(images, minlength=len(curves.left)) < 2] = 0
    changed = [
        _reduced(curve, basis, draft.coefficients_of(k), own)
        for k, (curve, basis, own) in enumerate(
            zip(
                draft.present_curves(),
                curves.bases,
                np.split(number, curves.segment_start[1:-1]),
                strict=True,
            )
        )
    ]
    if all(new is old for new, old in zip(changed, draft.present_curves(), strict=True)):
        return draft
    return with_curves(draft, tuple(changed))


def _reduced(curve: Curve, basis: CurveBasis, coefficients: FloatArray, number: IntArray) -> Curve:
    """A curve with the supported ones of its knots; ends stay."""
    if curve.closed:
        keep = supported_knots(number, True, cut_ends=False)
    else:
        keep = supported_knots_between(number, curve.breaks)
    if len(keep) == len(curve.values):
        return curve
    parameters = basis.break_points[keep]
    if basis.closed:
        parameters = np.append(parameters, parameters[0] + basis.break_points[-1] - basis.break_points[0])
    values = basis.evaluate(basis.break_points[keep], coefficients)
    return replace(
        curve, values=values, sigma=np.full_like(values, np.inf), knot_parameters=parameters,
        breaks=breaks_among(parameters, corner_parameters(curve, basis)),
    )  # fmt: skip
