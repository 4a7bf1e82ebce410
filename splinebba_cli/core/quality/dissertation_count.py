"""The redundancy budget of Lee (2008), tables 5.1 and 5.2, beside the rank of the design.

Table 5.1: 12 unknowns for every segment of a tie spline, 9 where its start point is known, 0 on a control spline, and
one location for every measured point; 2 n m + m (n - 1) equations of n points and the arc lengths between them in m
images leave the redundancy 2 n m - m - 12 of one segment.  Lines have 4 unknowns, points 3.  Table 5.2: at most 4, 3, 2
or 1 independent points on a segment of degree 3, 2, 1 or 0 in one image.

Both differ from the rank: continuity is not counted, the gauge of the locations is taken for determined, and one image
of a cubic segment gives 8 independent conditions (7 of a planar one), one a point, not 4.  (theory, sections 6 and 9)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.registry import FAMILIES
from splinebba_cli.core.network import BoolArray, Curve, IntArray
from splinebba_cli.core.quality.rank_contributions import FeatureRank
from splinebba_cli.core.state import Prepared

SEGMENT_UNKNOWNS, LINE_UNKNOWNS = 12, 4
MOST_CONDITIONS = {1: 2, 2: 5, 3: 8}  # of one image of a segment by degree


@dataclass(frozen=True)
class PrintedCount:
    """What the tables count for one feature; None where they know nothing like it."""

    unknowns: int | None  # locations included
    redundancy: int | None
    independent_points: int | None  # sum over images


def printed_count_of_curve(
    prepared: Prepared, number: int, points: int, arcs: int, independent_points: int
) -> PrintedCount:
    """Counts of one curve.

    Parameters
    ----------
    points, arcs : numbers of its measured points and arc lengths
    independent_points : by table 5.2
    """
    curve = prepared.network.curves[number]
    coefficients = _coefficients(prepared, number)
    unknowns = None if coefficients is None else coefficients + points
    weighted = np.isfinite(curve.sigma) & (curve.sigma > 0.0)
    given = 0 if np.isfinite(curve.sigma).all() else int(np.count_nonzero(weighted))
    redundancy = None if unknowns is None else 2 * points + arcs + given - unknowns
    return PrintedCount(unknowns, redundancy, independent_points if _has_degree(curve) else None)


def printed_independent_points(prepared: Prepared, segment: IntArray) -> IntArray:
    """Table 5.2, summed over the images of every curve, (nc,); of families that have no degree it means nothing.

    Parameters
    ----------
    segment : (n,) segment number of every measured point, in the curve set
    """
    observed, curves = prepared.network.curve_observations, prepared.network.curves
    images = max(len(prepared.network.images.ids), 1)
    _, one, counts = np.unique(segment * images + observed.image, return_index=True, return_counts=True)
    most = np.array([FAMILIES[curve.family].degree + 1 for curve in curves], dtype=np.int64)
    curve = observed.curve[one]
    found = np.zeros(len(curves), dtype=np.int64)
    np.add.at(found, curve, np.minimum(counts, most[curve]))
    return found


def printed_count_of_point(rays: int, free: int, given: int) -> PrintedCount:
    """Counts of one object point: 2 m - 3 of a tie point in m images, its given coordinates beside them."""
    return PrintedCount(free, 2 * rays + given - free, None)


def _coefficients(prepared: Prepared, number: int) -> int | None:
    curve = prepared.network.curves[number]
    if np.isfinite(curve.sigma).all():
        return 0
    if curve.family == "straight_line":
        return LINE_UNKNOWNS if np.isinf(curve.sigma).all() else None
    if not _is_cubic_spline(curve):
        return None
    segments = prepared.curves.bases[number].segment_count
    starts = curve.sigma[::4] if curve.family != "natural_cubic" else curve.sigma[:segments]
    return SEGMENT_UNKNOWNS * segments - int(np.count_nonzero(starts == 0.0))


def _is_cubic_spline(curve: Curve) -> bool:
    return curve.family in {"natural_cubic", "free_cubic", "polynomial_3"}


def _has_degree(curve: Curve) -> bool:
    return FAMILIES[curve.family].rows != "harmonics" and not curve.family.startswith(
        ("bspline", "cardinal", "catmull")
    )


def reason_of_curve(
    prepared: Prepared,
    number: int,
    free: BoolArray,
    locations: int,
    rank: FeatureRank | None,
    printed: PrintedCount,
) -> str:
    """Why the count of the tables is not the rank, in short sentences; empty where they agree.

    Parameters
    ----------
    free : (c, 3) coefficients of the curve that are unknowns
    locations : number of its locations that are unknowns
    """
    curve, segments = prepared.network.curves[number], prepared.curves.bases[number].segment_count
    said = []
    if free.any() and np.isfinite(curve.sigma).all():
        said.append("weighted control: its coefficients are unknowns and its given values as many equations")
    elif free.any() and printed.unknowns is not None:
        said.append(_of_coefficients(curve, segments, int(free.sum())))
    if rank is not None and rank.own < free.sum() and curve.family != "straight_line":
        said.append(_of_nulls(curve, segments, int(free.sum()) - rank.own, int(free.sum()) + locations))
    if rank is not None and (rank.independent_points or 0) > (printed.independent_points or np.inf):
        said.append(_of_points(FAMILIES[curve.family].degree))
    return "; ".join(filter(None, said))


def _of_coefficients(curve: Curve, segments: int, coefficients: int) -> str:
    if curve.family == "straight_line":
        return "line: 4 parameters, written as two end points that slide along it"
    if curve.family == "natural_cubic":
        number, given = (3 * segments, "3n") if curve.closed else (3 * (segments + 1), "3(n+1)")
        said = f"natural spline: {given} = {number} coefficients"
        held = number - coefficients
        said += f", {held} of them given" if held else ""
    elif curve.continuity < 0:
        return ""
    else:
        said = f"C{curve.continuity} joints: {coefficients} free coefficients"
    return f"{said}, not 12n = {SEGMENT_UNKNOWNS * segments}: continuity takes the rest"


def _of_nulls(curve: Curve, segments: int, nulls: int, unknowns: int) -> str:
    rank = f"rank {unknowns - nulls} of {unknowns}"
    if FAMILIES[curve.family].rows == "powers" and curve.continuity < 0:
        held = (curve.sigma.reshape(segments, -1, 3)[:, 0] == 0.0).all(axis=1)
        if nulls == int(np.where(held, 1, 2).sum()):
            gauge = (
                "t → αt of a segment with a known start point"
                if held.all()
                else "t → αt + β of a free segment"
            )
            return f"the gauge {gauge} is seen by no measurement, arc lengths included: {rank}"
    if FAMILIES[curve.family].rows == "harmonics" and nulls == 1:
        return f"the phase of u is seen by no measurement: {rank}"
    return f"{nulls} direction{'s' if nulls > 1 else ''} that none of its measurements sees: {rank}"


def _of_points(degree: int) -> str:
    name = {1: "linear", 2: "quadratic", 3: "cubic"}[degree]
    planar = " (7 if it is planar)" if degree == 3 else ""
    return (
        f"one image of a {name} segment gives up to {MOST_CONDITIONS[degree]} independent conditions{planar}: "
        f"table 5.2 counts {degree + 1}"
    )
