"""Where open curves begin and end: as far as two images show them.

A curve is carried on straight beyond its ends, points are linked, and it is cut back to where a second image still has
linked points: one image alone says nothing about depth.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.kept_corners import breaks_among, corner_parameters
from splinebba_cli.core.matching.shapes.draft import Draft, with_curves
from splinebba_cli.core.network import Curve, FloatArray
from splinebba_cli.core.row_groups import split_by

STEP = 6.0  # spacings of points by which a curve is carried on at once
SHORTEST = 0.3  # end segments, of the mean segment: a knot closer to the new end is left out
SAME = 1e-6  # distance of links below which they are one place, a point given twice: they say nothing about spacings


def extended(draft: Draft) -> Draft:
    """Open curves carried on straight at both ends."""
    spacing = point_spacing(draft)
    curves = []
    for k, curve in enumerate(draft.present_curves()):
        basis = draft.prepared.curves.bases[k]
        low, high = basis.break_points[0], basis.break_points[-1]
        step = STEP * spacing[k]
        if curve.closed or not np.isfinite(step):
            curves.append(curve)
        else:
            curves.append(on_domain(curve, basis, draft.coefficients_of(k), low - step, high + step))
    return with_curves(draft, tuple(curves))


def cut_back(draft: Draft) -> Draft:
    """Open curves between the outermost links that a second image confirms; links beyond are taken away."""
    curves, keep = [], np.ones(len(draft.row), dtype=bool)
    for k, curve in enumerate(draft.present_curves()):
        basis = draft.prepared.curves.bases[k]
        own = draft.links_by_curve[k]
        extent = None if curve.closed else confirmed_extent(draft, k)
        if extent is None:
            curves.append(curve)
            continue
        location = draft.state.location[own]
        keep[own] = (location >= extent[0]) & (location <= extent[1])
        curves.append(on_domain(curve, basis, draft.coefficients_of(k), *extent))
    return with_curves(draft.with_links(keep), tuple(curves))


def confirmed_extent(draft: Draft, curve: int) -> tuple[float, float] | None:
    """First and last location up to which two images have links; None where there is none."""
    own = draft.links_by_curve[curve]
    image, location = draft.links.image[own], draft.state.location[own]
    names = np.unique(image)
    if len(names) < 2:
        return None
    low = np.sort([location[image == i].min() for i in names])[1]
    high = np.sort([location[image == i].max() for i in names])[-2]
    return (float(low), float(high)) if low < high else None


def point_spacing(draft: Draft) -> FloatArray:
    """Usual distance of neighbouring links of one image along every curve, in units of u, (nc,)."""
    order = np.lexsort((draft.state.location, draft.links.image, draft.links.curve))
    curve, image = draft.links.curve[order], draft.links.image[order]
    step = np.diff(draft.state.location[order])
    inside = (np.diff(curve) == 0) & (np.diff(image) == 0) & (step > SAME)
    groups = split_by(curve[1:][inside], len(draft.curves))
    return np.array([np.median(step[inside][own]) if len(own) else np.nan for own in groups])


def on_domain(curve: Curve, basis: CurveBasis, coefficients: FloatArray, low: float, high: float) -> Curve:
    """An open natural spline that begins and ends elsewhere."""
    breaks = basis.break_points
    least = SHORTEST * (high - low) / max(len(breaks) - 1, 1)
    inner = breaks[(breaks > low + least) & (breaks < high - least)]
    parameters = np.concatenate([[low], inner, [high]])
    knots = straight_on(basis, coefficients, parameters)
    return replace(
        curve, values=knots, sigma=np.full_like(knots, np.inf), knot_parameters=parameters, reference=None,
        breaks=breaks_among(parameters, corner_parameters(curve, basis)),
    )  # fmt: skip


def straight_on(basis: CurveBasis, coefficients: FloatArray, u: FloatArray) -> FloatArray:
    """Points of the curve, beyond its ends along the tangents there, (n, 3)."""
    inside = np.clip(u, basis.break_points[0], basis.break_points[-1])
    return np.asarray(
        basis.evaluate(inside, coefficients) + (u - inside)[:, None] * basis.evaluate(inside, coefficients, 1)
    )
