"""Least squares fit of a natural cubic spline to points of a curve, the knots given.

With B the values of the basis at the locations u_i of the points p_i and weights w_i,

    sum_i w_i |X(u_i) - p_i|² = min,   N P = Bᵀ W p,   N = Bᵀ W B + ε diag(Bᵀ W B)

N is banded: four coefficients belong to one location.  The band of a closed spline is folded (0, n - 1, 1, n - 2, ...),
so that its two ends lie side by side.  The small ε keeps coefficients determined that too few points see; it acts
on the difference from the polyline of the points.

Distances are orthogonal: the location of a point moves to its foot point, (X(u) - p)ᵀ X'(u) = 0, by Newton's method.
Where the points with the largest distances decide, their weights grow in proportion (Lawson 1961): the fit
goes from least squares towards the least largest distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solveh_banded

from splinebba_cli.core.curves.basis import CurveBasis, power_row
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.curves.polyline import Polyline
from splinebba_cli.core.network import FloatArray, IntArray

RIDGE = 1e-11  # ε: changes a coefficient by this share of its distance from the polyline
FOOT_POINT_STEPS = 3
REWEIGHTINGS = 5
HOPELESS = 2.0  # times the threshold: no reweighting can help


@dataclass(frozen=True)
class KnotFit:
    """A fit on given knots; a starting point for the fit on changed ones."""

    knots: FloatArray  # (k,) parameters; closed: with the end of the last segment
    coefficients: FloatArray  # (m, 3) metres
    location: FloatArray  # (n,) foot points
    weight: FloatArray  # (n,)
    distance: FloatArray  # (n,) metres, of the points from the curve

    @property
    def largest(self) -> float:
        """Largest distance, metres."""
        return float(self.distance.max())


def basis_on(polyline: Polyline, knots: FloatArray) -> CurveBasis:
    """The basis on knots that hold the corners of the polyline."""
    breaks = tuple(int(i) for i in np.searchsorted(knots, polyline.corners))
    return natural_cubic_basis(knots, polyline.closed, breaks)


def first_knots(polyline: Polyline) -> FloatArray:
    """The fewest knots: ends and corners; two more on a closed curve."""
    inner = np.array([])
    if polyline.closed:
        third = len(polyline.points) / 3.0
        inner = polyline.parameters[[round(third), round(2.0 * third)]]
    return np.unique(np.concatenate([polyline.parameters[:1], inner, polyline.corners, [polyline.end]]))


def fitted(polyline: Polyline, knots: FloatArray, threshold: float) -> KnotFit:
    """The fit that begins with the parameters of the polyline as locations and equal weights.

    A polyline that meets itself at a corner keeps its ends together by a large weight.
    """
    weight = np.ones(len(polyline.points))
    if polyline.meets_itself:
        weight[[0, -1]] = 1e6
    return _reweighted(
        polyline, _solved(polyline, knots, polyline.parameters, weight), threshold, REWEIGHTINGS
    )


def refitted(
    polyline: Polyline, before: KnotFit, knots: FloatArray, threshold: float, reweightings: int = REWEIGHTINGS
) -> KnotFit:
    """The fit on other knots, with the locations and weights of an earlier one; reweighted where that may help.

    Parameters
    ----------
    knots : (k,) float, ascending; first, last and corners as before
    threshold : metres
    """
    fit = _solved(polyline, knots, before.location, before.weight)
    return _reweighted(polyline, fit, threshold, reweightings)


def _reweighted(polyline: Polyline, fit: KnotFit, threshold: float, reweightings: int) -> KnotFit:
    """The best of some fits with growing weights of the points beyond the threshold."""
    best = fit
    for _ in range(reweightings):
        if best.largest <= threshold or fit.largest > HOPELESS * threshold:
            break
        weight = fit.weight * np.maximum(fit.distance / threshold, 1.0) ** 2
        fit = _solved(polyline, fit.knots, fit.location, weight / weight.mean())
        if fit.largest < best.largest:
            best = fit
    return best


def _solved(polyline: Polyline, knots: FloatArray, location: FloatArray, weight: FloatArray) -> KnotFit:
    basis = basis_on(polyline, knots)
    segment, t = basis.locate(location)
    reference = polyline.at(basis.anchors)
    along_polyline = _values(basis.power @ reference[basis.columns], segment, t)
    moments, right = _moments(basis.segment_count, segment, t, weight, polyline.points - along_polyline)
    power = basis.power
    hankel = moments[:, np.arange(4)[:, None] + np.arange(4)]  # sum w t^(k + l)
    normal = np.einsum("skw,skl,slv->swv", power, hankel, power, optimize=True)
    coefficients = reference + _banded_solution(basis, normal, np.einsum("skw,skd->swd", power, right))
    location, distance = _foot_points(basis, coefficients, polyline.points, location)
    return KnotFit(knots, coefficients, location, weight, distance)


def _moments(
    segments: int, segment: IntArray, t: FloatArray, weight: FloatArray, residual: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Sums over every segment of w t^k, (S, 7), and of w t^k r, (S, 4, 3)."""
    powers = t[:, None] ** np.arange(7) * weight[:, None]
    rows = np.concatenate([powers, (powers[:, :4, None] * residual[:, None, :]).reshape(-1, 12)], axis=1)
    if np.any(segment[1:] < segment[:-1]):
        order = np.argsort(segment, kind="stable")
        segment, rows = segment[order], rows[order]
    first = np.flatnonzero(np.diff(segment, prepend=-1))
    sums = np.zeros((segments, 19))
    sums[segment[first]] = np.add.reduceat(rows, first, axis=0)
    return sums[:, :7], sums[:, 7:].reshape(segments, 4, 3)


def _banded_solution(basis: CurveBasis, normal: FloatArray, right: FloatArray) -> FloatArray:
    """Solve the normal equations given segment by segment, (S, w, w) and (S, w, 3)."""
    count = basis.coefficient_count
    place = np.arange(count)
    if basis.closed:
        place = np.where(2 * place < count, 2 * place, 2 * (count - 1 - place) + 1)
    columns = place[basis.columns]
    row, column = np.broadcast_arrays(columns[:, :, None], columns[:, None, :])
    lower = row >= column
    below = (row - column)[lower]
    width = int(below.max()) + 1
    band = np.bincount(below * count + column[lower], normal[lower], minlength=width * count)
    band = band.reshape(width, count)
    band[0] += RIDGE * band[0] + 1e-14 * band[0].max()
    sums = np.stack(
        [np.bincount(columns.ravel(), right[..., k].ravel(), minlength=count) for k in range(3)], axis=1
    )
    return np.asarray(solveh_banded(band, sums, lower=True, check_finite=False))[place]


def _values(polynomials: FloatArray, segment: IntArray, t: FloatArray, order: int = 0) -> FloatArray:
    """Polynomials (S, 4, 3) of the segments, or a derivative d/dt, at t, (n, 3)."""
    return np.asarray(np.einsum("nk,nkd->nd", power_row(t, order), polynomials[segment]))


def _foot_points(
    basis: CurveBasis, coefficients: FloatArray, points: FloatArray, location: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Foot points near the given locations, and the distances from them."""
    polynomials = basis.power @ coefficients[basis.columns]
    first, last = basis.break_points[0], basis.break_points[-1]
    length = np.diff(basis.break_points)
    for _ in range(FOOT_POINT_STEPS):
        segment, t = basis.locate(location)
        residual = _values(polynomials, segment, t) - points
        tangent = _values(polynomials, segment, t, 1)
        square = np.sum(tangent * tangent, axis=1)
        hessian = square + np.sum(residual * _values(polynomials, segment, t, 2), axis=1)
        hessian = np.maximum(np.where(hessian > 0.2 * square, hessian, square), 1e-300)
        step = -np.sum(residual * tangent, axis=1) / hessian
        location = location + np.clip(step, -0.5, 0.5) * length[segment]
        if not basis.closed:
            location = np.clip(location, first, last)
    segment, t = basis.locate(location)
    return location, np.linalg.norm(_values(polynomials, segment, t) - points, axis=1)
