"""Adjusted curves of whatever families compared across: their distance along the first one, with its sigma from both.

At the samples of the first curve, d is the difference to the nearest point of the second, across both. With the
lateral dispersions C_1 and C_2 (normal planes) the sigma of the distance is sqrt(e'(C_1 + C_2) e), e = d / |d|, and
d'(C_1 + C_2)^+ d is chi-square with two degrees of freedom where both curves are the same and were adjusted from
independent measurements.  What they share (orientations that were adjusted with them) is not taken into account: it
makes the predicted sigma too large.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray
from splinebba_cli.core.result import CurveResult


@dataclass(frozen=True)
class AdjustedCurve:
    """A curve as it was adjusted (`AdjustmentResult.network.curves`) and what was found for it."""

    curve: Curve
    result: CurveResult


@dataclass(frozen=True)
class CurveComparison:
    """Distances across at the samples of the first curve; those beyond an end of an open second one are left out."""

    u: FloatArray  # (n,) of the first curve
    difference: FloatArray  # (n, 3) first - second, m
    distance: FloatArray  # (n,) m
    sigma: FloatArray  # (n,) of the distance, in its direction, m
    normalized: FloatArray  # (n,) sqrt(d' C^+ d / 2); 1 in the mean square for the same curve

    @property
    def rms(self) -> float:
        """Root mean square of the distances, m."""
        return float(np.sqrt(np.mean(self.distance**2)))

    @property
    def sigma_rms(self) -> float:
        """Root mean square of their standard deviations, m."""
        return float(np.sqrt(np.mean(self.sigma**2)))


def compare_curves(first: AdjustedCurve, second: AdjustedCurve) -> CurveComparison:
    """The first curve less the second one, across, along the first one.

    Raises
    ------
    ValueError
        If no sample of the first curve has a foot point on the second.
    """
    origin = first.result.sample_xyz.mean(axis=0)
    basis, coefficients = _shape(second, origin)
    xyz = first.result.sample_xyz - origin
    place, _ = nearest_on_curve(basis, coefficients, xyz)
    inside = np.ones(len(place), dtype=bool)
    if not basis.closed:
        inside = (place > basis.break_points[0]) & (place < basis.break_points[-1])
    if not inside.any():
        raise ValueError(f"curves {first.curve.id} and {second.curve.id} have no part in common")
    u, place = first.result.sample_u[inside], place[inside]
    difference = xyz[inside] - basis.evaluate(place, coefficients)
    spread = _lateral(first, *_shape(first, origin))[inside] + _at(second, basis, coefficients, place)
    distance = np.linalg.norm(difference, axis=1)
    direction = np.where(distance[:, None] > 0.0, difference / np.maximum(distance, 1e-300)[:, None], 0.0)
    variance = np.einsum("ni,nij,nj->n", direction, spread, direction)
    across = np.linalg.pinv(spread, rcond=1e-9, hermitian=True)
    square = np.einsum("ni,nij,nj->n", difference, across, difference)
    return CurveComparison(
        u, difference, distance, np.sqrt(np.maximum(variance, 0.0)), np.sqrt(np.maximum(square, 0.0) / 2.0)
    )


def _shape(one: AdjustedCurve, origin: FloatArray) -> tuple[CurveBasis, FloatArray]:
    """Basis and coefficients of an adjusted curve, positions less an origin."""
    basis = basis_of(replace(one.curve, values=one.result.values))
    shift = np.where(basis.value_is_position[:, None], origin, 0.0)
    return basis, basis.coefficients_from_values(one.result.values - shift)


def _lateral(one: AdjustedCurve, basis: CurveBasis, coefficients: FloatArray) -> FloatArray:
    """Dispersion in the normal plane at the samples of a curve, (p, 3, 3), from its standard ellipses."""
    result = one.result
    tangent = basis.evaluate(result.sample_u, coefficients, 1)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
    major = result.sample_across_direction
    minor = np.cross(tangent, major)
    larger, smaller = result.sample_across[:, 0, None, None], result.sample_across[:, 1, None, None]
    return np.asarray(
        larger**2 * major[:, :, None] * major[:, None, :] + smaller**2 * minor[:, :, None] * minor[:, None, :]
    )


def _at(one: AdjustedCurve, basis: CurveBasis, coefficients: FloatArray, u: FloatArray) -> FloatArray:
    """Dispersion in the normal plane at other places, (n, 3, 3), between the samples on either side."""
    places, spread = one.result.sample_u, _lateral(one, basis, coefficients)
    if basis.closed:
        places = np.append(places, basis.break_points[-1])
        spread = np.concatenate([spread, spread[:1]])
    wrapped = u if not basis.closed else _wrapped(u, basis)
    after = np.clip(np.searchsorted(places, wrapped), 1, len(places) - 1)
    share = np.clip((wrapped - places[after - 1]) / (places[after] - places[after - 1]), 0.0, 1.0)
    mixed = (1.0 - share)[:, None, None] * spread[after - 1] + share[:, None, None] * spread[after]
    tangent = basis.evaluate(u, coefficients, 1)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
    plane = np.eye(3) - tangent[:, :, None] * tangent[:, None, :]
    return np.asarray(plane @ mixed @ plane)


def _wrapped(u: FloatArray, basis: CurveBasis) -> FloatArray:
    first, last = basis.break_points[0], basis.break_points[-1]
    return np.asarray(first + np.mod(u - first, last - first))
