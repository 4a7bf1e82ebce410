"""Errors of one adjustment: against the truth, or against another solution, in units and in predicted σ.

Curves are compared across: the vector from the nearest point of the true curve, less its part along the tangent.  It
does not depend on parameters or on where knots have slid.

Locations are compared on curves whose every value is given (σ finite; 0: held).  There the parameter is determined by
what is given; elsewhere the location of a measured point, as every figure along a curve, depends on the gauge
conditions, and an error of it would be one of the datum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.camera.rotation import wrap_angle
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray, Network
from splinebba_cli.core.result import AdjustmentResult, CurveResult
from splinebba_cli.simulation.truth import Shape, Truth, shape_of

SAMPLES_PER_CURVE = 16
HELD_M = 1e-7  # standard deviation below which a direction is held


@dataclass(frozen=True)
class CurveErrors:
    """Errors of one curve across, at places along it."""

    across: (
        FloatArray  # (p, 2) m: to the left in plan, and at right angles to that (upwards of a level curve)
    )
    normalized: FloatArray  # (p, 2) over the semi-axes of the lateral standard ellipse; NaN where held


@dataclass(frozen=True)
class RunErrors:
    """Errors of one adjustment; NaN where nothing is estimated.  Normalised by a-priori dispersions."""

    eop: FloatArray  # (m, 6) omega, phi, kappa (rad), X0, Y0, Z0 (m)
    eop_normalized: FloatArray  # (m, 6)
    image_squares: FloatArray  # (m,) e' D^-1 e of all estimated elements of an image
    points: FloatArray  # (n, 3) m
    points_normalized: FloatArray  # (n, 3)
    curves: tuple[CurveErrors, ...]
    locations: FloatArray  # (q,) of the points measured on curves whose every value is given, units of u
    locations_normalized: FloatArray  # (q,)


@dataclass(frozen=True)
class Reference:
    """What a result is compared with, in the local frame."""

    eop: FloatArray  # (m, 6)
    points: FloatArray  # (n, 3)
    shapes: tuple[Shape, ...]
    locations: FloatArray  # (n,) of all measured curve points; NaN where unknown


def reference_of_truth(network: Network, truth: Truth) -> Reference:
    """The truth of a simulated network, before its adjustment."""
    shapes = tuple(shape_of(c, values) for c, values in zip(network.curves, truth.curves, strict=True))
    return Reference(truth.eop, truth.points, shapes, truth.locations)


def reference_of_result(result: AdjustmentResult) -> Reference:
    """Another solution of the same network."""
    origin = result.network.origin
    eop = result.images.eop.copy()
    eop[:, 3:] -= origin
    shapes = []
    for curve, found in zip(result.network.curves, result.curves, strict=True):
        shift = np.where(basis_of(curve).value_is_position[:, None], origin, 0.0)
        shapes.append(shape_of(curve, found.values - shift))
    return Reference(eop, result.points.xyz - origin, tuple(shapes), result.curve_residuals.location)


def dispersion_factor(result: AdjustmentResult) -> float:
    """σ̂₀/σ₀ by which the standard deviations of a result were multiplied; 1 where they were not."""
    statistics = result.statistics
    if not result.network.settings.scale_dispersion or not statistics.sigma0 > 0.0:
        return 1.0
    return statistics.sigma0 / statistics.sigma0_prior


def run_errors(result: AdjustmentResult, reference: Reference) -> RunErrors:
    """Result minus reference, and the same over the a-priori standard deviations of the result."""
    factor = dispersion_factor(result)
    eop = result.images.eop - reference.eop
    eop[:, 3:] -= result.network.origin
    eop[:, :3] = wrap_angle(eop[:, :3])
    estimated = result.images.estimated
    dispersion = result.images.dispersion / factor**2
    points = result.points.xyz - result.network.origin - reference.points
    point_sigma = np.sqrt(np.maximum(np.einsum("nii->ni", result.points.dispersion), 0.0)) / factor
    known = point_sigma > 0.0
    origin = result.network.origin
    locations, locations_normalized = _location_errors(result, reference, factor)
    return RunErrors(
        eop=np.where(estimated, eop, np.nan),
        eop_normalized=_over(eop, np.sqrt(np.maximum(np.einsum("mii->mi", dispersion), 0.0)), estimated),
        image_squares=_squares(eop, dispersion, estimated),
        points=np.where(known, points, np.nan),
        points_normalized=_over(points, point_sigma, known),
        curves=tuple(
            _curve_errors(found, shape, origin, factor)
            for found, shape in zip(result.curves, reference.shapes, strict=True)
        ),
        locations=locations,
        locations_normalized=locations_normalized,
    )


def given_locations(network: Network) -> IntArray:
    """Numbers of the points measured on curves whose every value is given: their locations are determined."""
    given = np.array([bool(np.isfinite(curve.sigma).all()) for curve in network.curves], dtype=bool)
    if not given.any():
        return np.zeros(0, dtype=np.int64)
    return np.flatnonzero(given[network.curve_observations.curve])


def largest(errors: RunErrors) -> float:
    """Largest normalised error of all kinds; 0 where nothing is estimated."""
    parts = [errors.eop_normalized, errors.points_normalized, errors.locations_normalized]
    parts += [curve.normalized for curve in errors.curves]
    return max((float(np.nanmax(np.abs(p), initial=0.0)) for p in parts if p.size), default=0.0)


def _location_errors(
    result: AdjustmentResult, reference: Reference, factor: float
) -> tuple[FloatArray, FloatArray]:
    """Errors of the locations of :func:`given_locations`, the short way round closed curves; NaN where held."""
    rows = given_locations(result.network)
    if not len(rows):
        return np.zeros(0), np.zeros(0)
    table, curve = result.curve_residuals, result.network.curve_observations.curve[rows]
    error = table.location[rows] - reference.locations[rows]
    bases = [shape[0] for shape in reference.shapes]
    turn = np.array([b.break_points[-1] - b.break_points[0] if b.closed else np.inf for b in bases])[curve]
    turns = np.where(np.isfinite(turn) & np.isfinite(error), np.round(error / turn), 0.0)
    error -= np.where(np.isfinite(turn), turn, 0.0) * turns
    sigma = table.location_sigma[rows] / factor
    known = (sigma > 0.0) & np.isfinite(error)
    return np.where(known, error, np.nan), _over(error, sigma, known)


def _over(errors: FloatArray, sigma: FloatArray, known: BoolArray) -> FloatArray:
    return np.where(known, errors / np.where(known & (sigma > 0.0), sigma, 1.0), np.nan)


def _squares(errors: FloatArray, dispersion: FloatArray, estimated: BoolArray) -> FloatArray:
    squares = np.full(len(errors), np.nan)
    for i, free in enumerate(estimated):
        if free.any():
            e = errors[i, free]
            squares[i] = e @ np.linalg.solve(dispersion[i][np.ix_(free, free)], e)
    return squares


def _curve_errors(found: CurveResult, shape: Shape, origin: FloatArray, factor: float) -> CurveErrors:
    basis, coefficients = shape
    chosen = np.round(np.linspace(0, len(found.sample_u) - 1, SAMPLES_PER_CURVE)).astype(np.int64)
    xyz = found.sample_xyz[chosen] - origin
    u, _ = nearest_on_curve(basis, coefficients, xyz)
    tangent = _unit(basis.evaluate(u, coefficients, 1))
    tangent = np.where(np.any(tangent != 0.0, axis=1)[:, None], tangent, [0.0, 0.0, 1.0])  # a point: in plan
    error = xyz - basis.evaluate(u, coefficients)
    error -= np.einsum("pi,pi->p", error, tangent)[:, None] * tangent
    left = np.cross([0.0, 0.0, 1.0], tangent)
    level = np.linalg.norm(left, axis=1) > 1e-6
    left = _unit(np.where(level[:, None], left, np.cross([1.0, 0.0, 0.0], tangent)))
    upwards = np.cross(tangent, left)
    axes = found.sample_across[chosen] / factor
    major = found.sample_across_direction[chosen]
    minor = np.cross(tangent, major)
    along_axes = np.stack([np.sum(error * major, axis=1), np.sum(error * minor, axis=1)], axis=1)
    return CurveErrors(
        across=np.where(
            (axes[:, :1] > HELD_M),
            np.stack([np.sum(error * left, axis=1), np.sum(error * upwards, axis=1)], axis=1),
            np.nan,
        ),
        normalized=_over(along_axes, axes, axes > HELD_M),
    )


def _unit(vectors: FloatArray) -> FloatArray:
    norm = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(norm > 0.0, norm, 1.0))
