"""Results of every curve: values, knots, Lee's coefficients, precision across and along, residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis
from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.conic_elements import adjusted_conic
from splinebba_cli.core.quality.curve_precision import CurveSamples, segment_coefficients
from splinebba_cli.core.quality.nearest_ellipse import nearest_ellipse
from splinebba_cli.core.result import (
    ConicElements,
    CurveResult,
    Ellipse,
    ResidualTable,
    SegmentCoefficients,
)


def curve_results(
    cofactors: Cofactors, samples: CurveSamples, residuals: ResidualTable, scale: float
) -> tuple[CurveResult, ...]:
    """One result a curve; positions in the user's frame, dispersions scaled."""
    prepared = cofactors.assembler.prepared
    network, curves = prepared.network, prepared.curves
    coefficients, sigma = segment_coefficients(cofactors, scale)
    coefficients = coefficients.copy()
    coefficients[:, 0] += network.origin
    observed = network.curve_observations
    order = np.argsort(observed.curve, kind="stable")
    bounds = np.searchsorted(observed.curve[order], np.arange(len(curves.bases) + 1))
    sample_bounds = np.searchsorted(samples.curve, np.arange(len(curves.bases) + 1))
    values = _values_dispersion(cofactors) * scale
    value_bounds = np.concatenate([[0], np.cumsum([len(basis.value_columns) for basis in curves.bases])])
    results = []
    for k in range(len(curves.bases)):
        rows = order[bounds[k] : bounds[k + 1]]
        place = slice(int(sample_bounds[k]), int(sample_bounds[k + 1]))
        value_rows = slice(int(value_bounds[k]), int(value_bounds[k + 1]))
        segments = slice(int(curves.segment_start[k]), int(curves.segment_start[k + 1]))
        pieces = SegmentCoefficients(_intervals(cofactors, k), coefficients[segments], sigma[segments])
        if curves.bases[k].trigonometric:
            pieces = SegmentCoefficients(np.zeros((0, 2)), np.zeros((0, 4, 3)), np.zeros((0, 4, 3)))
        results.append(_one(cofactors, k, samples, place, pieces, residuals, rows, values[value_rows], scale))
    return tuple(results)


def _intervals(cofactors: Cofactors, curve: int) -> FloatArray:
    breaks = cofactors.assembler.prepared.curves.bases[curve].break_points
    return np.stack([breaks[:-1], breaks[1:]], axis=1)


def _one(
    cofactors: Cofactors, k: int, samples: CurveSamples, place: slice, pieces: SegmentCoefficients,
    residuals: ResidualTable, rows: IntArray, values_dispersion: FloatArray, scale: float,
) -> CurveResult:  # fmt: skip
    prepared = cofactors.assembler.prepared
    network, curve, basis = prepared.network, prepared.network.curves[k], prepared.curves.bases[k]
    start = int(prepared.curves.coefficient_start[k])
    own = cofactors.solution.state.coefficients[start : start + basis.coefficient_count]
    shift = np.where(basis.value_is_position[:, None], network.origin, 0.0)
    at_knot = np.isin(samples.u[place], basis.break_points)
    knot_dispersion = samples.dispersion[place][at_knot]
    across = samples.across[place]
    rms = float(np.sqrt(np.mean(residuals.across[rows] ** 2))) if len(rows) else float("nan")
    reference = curve.values if curve.reference is None else curve.reference
    return CurveResult(
        values=basis.values_from_coefficients(own) + shift,
        values_dispersion=values_dispersion,
        knots=samples.xyz[place][at_knot] + network.origin,
        knot_parameters=samples.u[place][at_knot],
        knot_sigma=np.sqrt(np.maximum(np.einsum("kii->ki", knot_dispersion), 0.0)),
        reference=reference + shift,
        segments=pieces,
        sample_u=samples.u[place],
        sample_xyz=samples.xyz[place] + network.origin,
        sample_across=across,
        sample_across_direction=samples.direction[place],
        sigma_across_max=float(across[:, 0].max(initial=0.0)),
        sigma_across_mean=float(np.sqrt(np.mean(across**2))) if len(across) else 0.0,
        rms_across_mm=rms,
        n_observations=len(rows),
        n_images=len(np.unique(network.curve_observations.image[rows])),
        along_sigma=samples.along[place][at_knot],
        conic=_conic(cofactors, k, own, scale),
        ellipse=_ellipse(basis, own, network.origin),
    )


def _conic(cofactors: Cofactors, k: int, own: FloatArray, scale: float) -> ConicElements | None:
    """Elements of a conic or circle in the user's frame."""
    network = cofactors.assembler.prepared.network
    if network.curves[k].family not in ("conic", "circle"):
        return None
    found = adjusted_conic(cofactors, k, own, scale)
    return replace(found, centre=found.centre + network.origin)


def _ellipse(basis: CurveBasis, own: FloatArray, origin: FloatArray) -> Ellipse | None:
    """The ellipse nearest to a closed curve in the user's frame."""
    if not basis.closed:
        return None
    found = nearest_ellipse(basis, own)
    return replace(found, centre=found.centre + origin)


def _values_dispersion(cofactors: Cofactors) -> FloatArray:
    """Cofactors of the user's values of all curves, one after another, (K, 3, 3)."""
    prepared = cofactors.assembler.prepared
    support = prepared.curves.support
    columns, weights = [np.zeros((0, support), dtype=np.int64)], [np.zeros((0, support))]
    for basis, start in zip(prepared.curves.bases, prepared.curves.coefficient_start[:-1], strict=True):
        wide = support - basis.value_columns.shape[1]
        columns.append(np.pad(basis.value_columns, ((0, 0), (0, wide)), mode="edge") + start)
        weights.append(np.pad(basis.value_weights, ((0, 0), (0, wide))))
    place, weight = np.vstack(columns), np.vstack(weights)
    if not len(place):
        return np.zeros((0, 3, 3))
    blocks = cofactors.coefficient_windows(place).reshape(len(place), support, 3, support, 3)
    return np.asarray(np.einsum("kj,kjalb,kl->kab", weight, blocks, weight, optimize=True))
