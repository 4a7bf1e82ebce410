"""Adjusted curves of whatever families compared across: their distance along the first one, with its sigma from both.

At the samples of the first curve, d is the difference to the nearest point of the second, across both. With the
lateral dispersions C_1 and C_2 (normal planes) the sigma of the distance is sqrt(e'(C_1 + C_2) e), e = d / |d|, and
d'(C_1 + C_2)^-1 d in the normal plane of the second is chi-square with two degrees of freedom where both curves are the
same and were adjusted from independent measurements.  What they share (orientations that were adjusted with them) is
not taken into account: it makes the predicted sigma too large.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.curves.nearest import nearest_on_curve
from splinebba_cli.core.curves.registry import basis_of
from splinebba_cli.core.network import Curve, FloatArray, IntArray
from splinebba_cli.core.result import CurveResult

SMALL = 1e-9  # of the trace: a direction without variance (along the curve)
SHARE = 1e-3  # the same where C is a difference of dispersions


@dataclass(frozen=True)
class AdjustedCurve:
    """A curve as it was adjusted (`AdjustmentResult.network.curves`) and what was found for it."""

    curve: Curve
    result: CurveResult


@dataclass(frozen=True)
class SampledCurve:
    """An adjusted curve as a function and its standard ellipses across at samples, in one frame."""

    name: str
    basis: CurveBasis
    coefficients: FloatArray
    u: FloatArray  # (p,) samples
    xyz: FloatArray  # (p, 3)
    across: FloatArray  # (p, 2) semi-axes, larger first, m
    direction: FloatArray  # (p, 3) of the larger semi-axis


@dataclass(frozen=True)
class CurveComparison:
    """Distances across at the samples of the first curve; those beyond an end of an open second one are left out."""

    u: FloatArray  # (n,) of the first curve
    difference: FloatArray  # (n, 3) first - second, m
    distance: FloatArray  # (n,) m
    sigma: FloatArray  # (n,) of the distance, in its direction, m
    normalized: FloatArray  # (n,) sqrt(d' C^-1 d / 2); 1 in the mean square for the same curve
    dimensions: IntArray  # (n,) rank of C in the normal plane

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
    return compare_sampled(_sampled(first, origin), _sampled(second, origin))


def compare_sampled(
    first: SampledCurve, second: SampledCurve, factors: tuple[float, float] = (1.0, 1.0)
) -> CurveComparison:
    """The first curve less the second one, across, along the first one.

    Parameters
    ----------
    factors : (2,)
        C = factors[0] C_1 + factors[1] C_2; one is negative where one adjustment is part of the other.

    Raises
    ------
    ValueError
        If no sample of the first curve has a foot point on the second.
    """
    basis, coefficients = second.basis, second.coefficients
    place, _ = nearest_on_curve(basis, coefficients, first.xyz)
    inside = np.ones(len(place), dtype=bool)
    if not basis.closed:
        inside = (place > basis.break_points[0]) & (place < basis.break_points[-1])
    if not inside.any():
        raise ValueError(f"curves {first.name} and {second.name} have no part in common")
    u, place = first.u[inside], place[inside]
    difference = first.xyz[inside] - basis.evaluate(place, coefficients)
    own, other = _lateral(first)[inside], _at(second, place)
    spread = factors[0] * own + factors[1] * other
    distance = np.linalg.norm(difference, axis=1)
    direction = np.where(distance[:, None] > 0.0, difference / np.maximum(distance, 1e-300)[:, None], 0.0)
    variance = np.einsum("ni,nij,nj->n", direction, spread, direction)
    plane = _normal_plane(basis.evaluate(place, coefficients, 1))
    values, vectors = np.linalg.eigh(plane.transpose(0, 2, 1) @ spread @ plane)
    size = np.einsum("nii->n", abs(factors[0]) * own + abs(factors[1]) * other)
    kept = values > (SMALL if min(factors) > 0.0 else SHARE) * size[:, None]
    along = np.einsum("nij,nki,nk->nj", vectors, plane, difference)
    square = np.sum(np.where(kept, along**2 / np.where(kept, values, 1.0), 0.0), axis=1)
    sigma = np.sqrt(np.maximum(variance, 0.0))
    return CurveComparison(u, difference, distance, sigma, np.sqrt(square / 2.0), kept.sum(axis=1))


def _normal_plane(tangent: FloatArray) -> FloatArray:
    """Two unit vectors across tangents (n, 3), (n, 3, 2).

    The normal planes of two curves differ a little, so that the sum of their lateral dispersions has a small variance
    along them, too: it says nothing and is left out.
    """
    return np.asarray(np.linalg.svd(tangent[:, :, None], full_matrices=True)[0][:, :, 1:])


def _sampled(one: AdjustedCurve, origin: FloatArray) -> SampledCurve:
    """An adjusted curve with positions less an origin."""
    result = one.result
    basis, coefficients = _shape(one, origin)
    return SampledCurve(
        one.curve.id, basis, coefficients, result.sample_u, result.sample_xyz - origin,
        result.sample_across, result.sample_across_direction,
    )  # fmt: skip


def _shape(one: AdjustedCurve, origin: FloatArray) -> tuple[CurveBasis, FloatArray]:
    """Basis and coefficients of an adjusted curve, positions less an origin."""
    basis = basis_of(replace(one.curve, values=one.result.values))
    shift = np.where(basis.value_is_position[:, None], origin, 0.0)
    return basis, basis.coefficients_from_values(one.result.values - shift)


def _lateral(one: SampledCurve) -> FloatArray:
    """Dispersion in the normal plane at the samples of a curve, (p, 3, 3), from its standard ellipses."""
    tangent = one.basis.evaluate(one.u, one.coefficients, 1)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
    major = one.direction
    minor = np.cross(tangent, major)
    larger, smaller = one.across[:, 0, None, None], one.across[:, 1, None, None]
    return np.asarray(
        larger**2 * major[:, :, None] * major[:, None, :] + smaller**2 * minor[:, :, None] * minor[:, None, :]
    )


def _at(one: SampledCurve, u: FloatArray) -> FloatArray:
    """Dispersion in the normal plane at other places, (n, 3, 3), between the samples on either side."""
    basis, places, spread = one.basis, one.u, _lateral(one)
    if basis.closed:
        places = np.append(places, basis.break_points[-1])
        spread = np.concatenate([spread, spread[:1]])
    wrapped = u if not basis.closed else _wrapped(u, basis)
    after = np.clip(np.searchsorted(places, wrapped), 1, len(places) - 1)
    share = np.clip((wrapped - places[after - 1]) / (places[after] - places[after - 1]), 0.0, 1.0)
    mixed = (1.0 - share)[:, None, None] * spread[after - 1] + share[:, None, None] * spread[after]
    tangent = basis.evaluate(u, one.coefficients, 1)
    tangent = tangent / np.maximum(np.linalg.norm(tangent, axis=1), 1e-300)[:, None]
    plane = np.eye(3) - tangent[:, :, None] * tangent[:, None, :]
    return np.asarray(plane @ mixed @ plane)


def _wrapped(u: FloatArray, basis: CurveBasis) -> FloatArray:
    first, last = basis.break_points[0], basis.break_points[-1]
    return np.asarray(first + np.mod(u - first, last - first))
