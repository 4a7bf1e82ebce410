"""A natural cubic spline through places with dispersions, weighted across the curve, knots inserted where it is worst.

With d_i = X(u_i) - x_i, the lateral weight W_i = F (F' D_i F)^-1 F' (F: two directions across the curve, D_i the
dispersion of the place) and a weak hold along the curve,

    sum_i h_i d_i' (W_i + t t' / s^2) d_i + w int |X''|^2 du = min,      h_i = min(1, ROBUST s / |d_i|_W)

The last part bridges what the places leave open, by the straightest curve: w belongs to a turn of one radian in BEND
spacings of places, which no measured stretch feels.

Locations move to the foot points between the solutions.  A segment is divided (Lee 2008, 2.3.1) where the mean
distance of neighbouring places is larger than the tolerance in their sigma: what one image shows by chance is no bend.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.natural_cubic import natural_cubic_basis
from splinebba_cli.core.network import FloatArray, IntArray

ROBUST = 3.0  # sigma from which a place counts less, times the typical distance of a poor fit
NEAR = 3.0  # typical distance over that of the right curve, from which on locations may move
MEDIAN = 1.177  # of the lateral distance of places from the right curve, in sigma
SOLUTIONS = 4
NEIGHBOURS = 5  # places whose mean distance decides over a knot
FEWEST = 6  # places in a segment that may be divided
SHORTEST = 2.0  # segments, in spacings of places
INSERTIONS = 14
RIDGE = 1e-9
BEND = 10.0  # spacings of places in which the bridge of a gap may turn by one radian
REACH = 2.0  # spacings by which a foot point may leave the first location of its place


@dataclass(frozen=True)
class PlaceFit:
    """A spline fitted to places."""

    basis: CurveBasis
    coefficients: FloatArray  # (m, 3) metres
    location: FloatArray  # (n,) foot points of the places
    distance: FloatArray  # (n,) across the curve, in sigma of the places

    def evaluate(self, u: FloatArray, order: int = 0) -> FloatArray:
        """Points of the curve, or derivatives d/du, (m, 3)."""
        return self.basis.evaluate(u, self.coefficients, order)

    @property
    def knots(self) -> FloatArray:
        """The knots, (k, 3) metres."""
        return self.basis.values_from_coefficients(self.coefficients)


@dataclass(frozen=True)
class Places:
    """What is fitted: places of one edge with their first locations."""

    location: FloatArray  # (n,) metres along, ascending or nearly so
    xyz: FloatArray  # (n, 3) metres
    dispersion: FloatArray  # (n, 3, 3) m^2
    closed: bool = False
    period: float = 0.0  # length of a closed one
    spacing: float = 0.0  # metres between neighbouring places of one image

    @property
    def layers(self) -> int:
        """How many images' places lie over each other."""
        extent = self.period or float(np.ptp(self.location))
        return max(1, round(len(self.location) * self.spacing / extent)) if extent > 0.0 else 1


def fit_places(places: Places, tolerance: float) -> PlaceFit:
    """The spline with few knots from which no stretch of places is farther than the tolerance.

    Parameters
    ----------
    tolerance : largest mean distance of neighbouring places, in their sigma
    """
    knots = _first_knots(places)
    fit = fit_on_knots(places, knots)
    for _ in range(INSERTIONS):
        new = _wanted_knots(places, fit, tolerance)
        if not len(new):
            break
        knots = np.sort(np.concatenate([knots, new]))
        fit = fit_on_knots(places, knots, fit.location)
    return fit


def fit_on_knots(places: Places, knots: FloatArray, location: FloatArray | None = None) -> PlaceFit:
    """The fit on given knot parameters (closed: with the end of the last segment)."""
    basis = natural_cubic_basis(knots, places.closed)
    u = places.location if location is None else location
    tangent = _polyline_tangents(places)
    weight = np.ones(len(u))
    for _ in range(SOLUTIONS):
        across = lateral_weights(tangent, places.dispersion)
        coefficients = _solved(basis, u, places, across, tangent, weight)
        if _scale(_distances(basis, coefficients, places, u)) < NEAR:
            u = _feet(basis, coefficients, places, u)
        tangent = _unit(basis.evaluate(u, coefficients, 1))
        distance = _distances(basis, coefficients, places, u)
        weight = np.minimum(1.0, ROBUST * _scale(distance) / np.maximum(distance, 1e-12))
    return PlaceFit(basis, coefficients, u, distance)


def lateral_weights(tangent: FloatArray, dispersion: FloatArray) -> FloatArray:
    """F (F' D F)^-1 F' with F across unit tangents, (n, 3, 3)."""
    frame = normal_frames(tangent)
    inner = np.linalg.inv(np.einsum("nia,nij,njb->nab", frame, dispersion, frame))
    return np.asarray(np.einsum("nia,nab,njb->nij", frame, inner, frame))


def normal_frames(tangent: FloatArray) -> FloatArray:
    """Two orthonormal directions across unit tangents, (n, 3, 2)."""
    still = np.sum(tangent * tangent, axis=1) == 0.0
    tangent = np.where(still[:, None], [1.0, 0.0, 0.0], tangent)
    axis = np.eye(3)[np.argmin(np.abs(tangent), axis=1)]
    first: FloatArray = np.cross(tangent, axis)
    first = first / np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    frames: FloatArray = np.empty((len(tangent), 3, 2))
    frames[:, :, 0], frames[:, :, 1] = first, np.cross(tangent, first)
    return frames


def _first_knots(places: Places) -> FloatArray:
    low, high = float(places.location.min()), float(places.location.max())
    if places.closed:
        return np.asarray(low + places.period * np.arange(5) / 4.0)
    return np.array([low, high])


def _polyline_tangents(places: Places) -> FloatArray:
    """Directions of the places as they are ordered, (n, 3) unit; over some neighbours, against noise."""
    order = np.argsort(places.location, kind="stable")
    xyz, count = places.xyz[order], len(order)
    reach = max(1, min(NEIGHBOURS * places.layers, count // 4))
    before, after = np.maximum(np.arange(count) - reach, 0), np.minimum(np.arange(count) + reach, count - 1)
    step = xyz[after] - xyz[before]
    length = np.linalg.norm(step, axis=1, keepdims=True)
    tangent = np.empty_like(step)
    tangent[order] = np.where(length > 0.0, step / np.where(length > 0.0, length, 1.0), [1.0, 0.0, 0.0])
    return tangent


def _solved(
    basis: CurveBasis, u: FloatArray, places: Places, across: FloatArray, tangent: FloatArray, weight: FloatArray
) -> FloatArray:  # fmt: skip
    """Coefficients of the weighted fit, (m, 3)."""
    segment, t = basis.locate(u)
    rows = np.einsum("nk,nkw->nw", t[:, None] ** np.arange(4), basis.power[segment])
    spacing = (basis.break_points[-1] - basis.break_points[0]) / max(len(u), 1)
    held = (4.0 * spacing) ** 2 + np.trace(places.dispersion, axis1=1, axis2=2)
    along = tangent[:, :, None] * tangent[:, None, :] / held[:, None, None]
    full = weight[:, None, None] * (across + along)
    columns = basis.columns[segment]
    unknown = 3 * columns[:, :, None] + np.arange(3)  # (n, w, 3)
    blocks = rows[:, :, None, None, None] * rows[:, None, :, None, None] * full[:, None, None]  # n w w 3 3
    row = np.broadcast_to(unknown[:, :, None, :, None], blocks.shape)
    column = np.broadcast_to(unknown[:, None, :, None, :], blocks.shape)
    size = 3 * basis.coefficient_count
    normal = csc_matrix(coo_matrix((blocks.ravel(), (row.ravel(), column.ravel())), shape=(size, size)))
    side = np.einsum("nw,nij,nj->nwi", rows, full, places.xyz)
    right: FloatArray = np.bincount(unknown.ravel(), side.ravel(), minlength=size).astype(np.float64)
    diagonal = normal.diagonal()
    reference = _straight(basis, places)
    ridge = RIDGE * diagonal + 1e-9 * max(float(diagonal.max()), 1e-300)
    right = right + ridge * reference.ravel()
    if places.spacing > 0.0:
        normal = csc_matrix(normal + bending(basis) * (BEND * places.spacing))
    damped = csc_matrix(normal + csc_matrix(coo_matrix((ridge, (np.arange(size), np.arange(size))))))
    return np.asarray(splu(damped).solve(right)).reshape(-1, 3)


def bending(basis: CurveBasis) -> csc_matrix:
    """Matrix of int |X''|^2 du over the coordinates of all coefficients, (3 m, 3 m)."""
    length = np.diff(basis.break_points)
    second = np.zeros((4, 4))
    second[2, 2], second[2, 3], second[3, 2], second[3, 3] = 4.0, 6.0, 6.0, 12.0  # of t^2, t^3 over [0, 1]
    own = np.einsum("skw,kl,slv->swv", basis.power, second, basis.power) / length[:, None, None] ** 3
    columns = 3 * basis.columns
    size = 3 * basis.coefficient_count
    row = np.broadcast_to(columns[:, :, None, None] + np.arange(3), (*own.shape, 3))
    column = np.broadcast_to(columns[:, None, :, None] + np.arange(3), (*own.shape, 3))
    values = np.broadcast_to(own[..., None], row.shape)
    return csc_matrix(coo_matrix((values.ravel(), (row.ravel(), column.ravel())), shape=(size, size)))


def _straight(basis: CurveBasis, places: Places) -> FloatArray:
    """Coefficients of the spline through the places nearest to its anchors, (m, 3): what the ridge holds to."""
    order = np.argsort(places.location, kind="stable")
    at = [np.interp(basis.anchors, places.location[order], places.xyz[order, k]) for k in range(3)]
    return basis.coefficients_from_values(np.stack(at, axis=1))


def _distances(basis: CurveBasis, coefficients: FloatArray, places: Places, u: FloatArray) -> FloatArray:
    """Distances across the curve at locations, in sigma of the places, (n,)."""
    off = basis.evaluate(u, coefficients) - places.xyz
    weight = lateral_weights(_unit(basis.evaluate(u, coefficients, 1)), places.dispersion)
    return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", off, weight, off)))


def _scale(distance: FloatArray) -> float:
    """Typical distance over that of the right curve; at least 1."""
    return max(1.0, float(np.median(distance)) / MEDIAN)


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300))


def _feet(basis: CurveBasis, coefficients: FloatArray, places: Places, u: FloatArray) -> FloatArray:
    """Foot points near the locations, (n,)."""
    reach = (
        REACH * places.spacing
        if places.spacing > 0.0
        else 0.25 * float(np.median(np.diff(basis.break_points)))
    )
    for _ in range(3):
        first = basis.evaluate(u, coefficients, 1)
        off = places.xyz - basis.evaluate(u, coefficients)
        square = np.maximum(np.sum(first * first, axis=1), 1e-300)
        u = u + np.clip(np.sum(off * first, axis=1) / square, -reach, reach)
        u = np.clip(u, places.location - reach, places.location + reach)
        if not basis.closed:
            u = np.clip(u, basis.break_points[0] - places.spacing, basis.break_points[-1] + places.spacing)
    return u


def _wanted_knots(places: Places, fit: PlaceFit, tolerance: float) -> FloatArray:
    """New knot parameters: where segments are divided, (q,)."""
    order = np.argsort(fit.location, kind="stable")
    u = fit.location[order]
    mean = _local_distances(places, fit, order)
    segment, _ = fit.basis.locate(u)
    breaks = fit.basis.break_points
    shortest = max(1e-3 * (breaks[-1] - breaks[0]), SHORTEST * places.spacing)
    new = []
    for k in np.unique(segment[mean > tolerance]):
        own = u[segment == k]
        if len(own) < FEWEST * places.layers:
            continue
        middle = float(np.median(own))
        if min(middle - breaks[k], breaks[k + 1] - middle) > shortest:
            new.append(middle)
    return np.array(new)


def _local_distances(places: Places, fit: PlaceFit, order: IntArray) -> FloatArray:
    """Distances of the mean of neighbouring places from the curve, in their sigma, in the order along, (n,)."""
    u = fit.location[order]
    off = fit.evaluate(u) - places.xyz[order]
    weight = lateral_weights(_unit(fit.evaluate(u, 1)), places.dispersion[order])
    half = min(NEIGHBOURS * places.layers, len(u)) // 2
    window = np.clip(np.arange(len(u))[:, None] + np.arange(-half, half + 1), 0, len(u) - 1)
    local = np.median(off[window], axis=1)
    return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", local, weight, local)))
