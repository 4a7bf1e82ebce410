"""Splines of two result folders compared across, whatever their families and knots."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.critical_values import single_alpha
from splinebba_cli.core.quality.curve_comparison import SampledCurve, compare_sampled
from splinebba_cli.core.quality.parameter_test import upper_probability
from splinebba_cli.core.quality.similarity_fit import Similarity
from splinebba_cli.output.stored_result import StoredResult


@dataclass(frozen=True)
class SplineDifference:
    """Distance across of one spline, A to B, at the samples of A."""

    id: str
    count: int  # samples with a foot point on B
    rms: float  # m
    largest: float  # m
    sigma_rms: float  # m; NaN without a dispersion
    normalized: float  # largest sqrt(d' C^-1 d / 2); NaN without one
    probability: float  # of the most significant sample
    significant: bool  # by Sidak's alpha of one sample of one of all splines


def spline_differences(
    a: StoredResult,
    b: StoredResult,
    factors: tuple[float, float, float | None] | None,
    similarity: Similarity | None,
    alpha: float,
) -> tuple[SplineDifference, ...]:
    """Every spline that both have.

    Parameters
    ----------
    factors : (factor of A, factor of B, degrees of freedom), optional
        C = factor_a C_a + factor_b C_b; None: no dispersion.
    """
    places = [knot for spline in a.content["splines"] for knot in spline["knots"]]
    origin = np.mean(places, axis=0) if places else np.zeros(3)
    first, second = a.curves(origin), b.curves(origin)
    both = [name for name in first if name in second]
    single = single_alpha(alpha, "sidak", len(both))
    found = []
    for name in both:
        other = second[name] if similarity is None else _transformed(second[name], similarity, origin)
        one = _compared(first[name], other, factors, single)
        if one is not None:
            found.append(one)
    return tuple(found)


def _compared(
    first: SampledCurve, second: SampledCurve, factors: tuple[float, float, float | None] | None, alpha: float
) -> SplineDifference | None:
    weights, degrees = ((1.0, 1.0), None) if factors is None else (factors[:2], factors[2])
    try:
        found = compare_sampled(first, second, weights)
    except ValueError:  # no part in common
        return None
    nan = float("nan")
    rms, largest = found.rms, float(found.distance.max())
    if factors is None:
        return SplineDifference(first.name, len(found.u), rms, largest, nan, nan, nan, False)
    probability = upper_probability(2.0 * found.normalized**2, found.dimensions, degrees)
    tested = int((found.dimensions > 0).sum())
    least = float(np.nanmin(probability)) if tested else nan
    significant = bool(tested and least < single_alpha(alpha, "sidak", tested))
    return SplineDifference(
        first.name,
        len(found.u),
        rms,
        largest,
        found.sigma_rms,
        float(found.normalized.max()),
        least,
        significant,
    )


def _transformed(curve: SampledCurve, similarity: Similarity, origin: FloatArray) -> SampledCurve:
    """A curve in the frame of A: positions moved, vectors turned and scaled."""
    position = curve.basis.value_is_position[:, None]
    values = curve.basis.values_from_coefficients(curve.coefficients)
    moved = similarity.apply(values + origin) - origin
    turned = similarity.scale * values @ similarity.rotation.T
    return replace(
        curve,
        coefficients=curve.basis.coefficients_from_values(np.where(position, moved, turned)),
        xyz=similarity.apply(curve.xyz + origin) - origin,
        across=similarity.scale * curve.across,
        direction=curve.direction @ similarity.rotation.T,
    )
