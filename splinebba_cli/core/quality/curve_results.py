"""Results of every curve: values, knots, Lee's coefficients, precision across and along, residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors
from splinebba_cli.core.quality.conic_elements import adjusted_conic
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.quality.curve_precision import CurveSamples, segment_coefficients
from splinebba_cli.core.quality.curve_values import CurveValues
from splinebba_cli.core.quality.nearest_ellipse import nearest_ellipse
from splinebba_cli.core.result import ConicElements, Ellipse, ResidualTable, SegmentCoefficients


def curve_results(
    cofactors: Cofactors, samples: CurveSamples, residuals: ResidualTable, scale: float
) -> CurveColumns:
    """One result a curve; positions in the user's frame, dispersions scaled."""
    prepared, state = cofactors.assembler.prepared, cofactors.solution.state
    network, curves = prepared.network, prepared.curves
    count = len(curves.bases)
    values = CurveValues.of(curves)
    shift = np.where(values.is_position[:, None], network.origin, 0.0)
    given = [curve.values if curve.reference is None else curve.reference for curve in network.curves]
    knots = np.flatnonzero(samples.at_knot)
    observed = network.curve_observations
    number = np.bincount(observed.curve, minlength=count)
    square = np.bincount(observed.curve, residuals.across**2, minlength=count)
    bounds = _bounds(samples.curve, count)
    largest, mean = _across(samples.across, bounds)
    return CurveColumns(
        value_bounds=values.bounds,
        values=values.at(state.coefficients) + shift,
        values_dispersion=values.cofactors(cofactors) * scale,
        reference=np.concatenate([np.zeros((0, 3)), *given]) + shift,
        knot_bounds=_bounds(samples.curve[knots], count),
        knots=samples.xyz[knots] + network.origin,
        knot_parameters=samples.u[knots],
        knot_sigma=np.sqrt(np.maximum(np.einsum("kii->ki", samples.dispersion[knots]), 0.0)),
        along_sigma=samples.along[knots],
        segment_bounds=curves.segment_start,
        segments=_segments(cofactors, scale),
        without_segments=frozenset(k for k, basis in enumerate(curves.bases) if basis.trigonometric),
        sample_bounds=bounds,
        sample_u=samples.u,
        sample_xyz=samples.xyz + network.origin,
        sample_across=samples.across,
        sample_across_direction=samples.direction,
        sigma_across_max=largest,
        sigma_across_mean=mean,
        rms_across_mm=np.sqrt(np.where(number > 0, square / np.maximum(number, 1), np.nan)),
        n_observations=number,
        n_images=_image_counts(observed.curve, observed.image, count),
        conics=_conics(cofactors, scale),
        ellipses=_ellipses(cofactors),
    )


def _bounds(curve: IntArray, count: int) -> IntArray:
    """Where the rows of every curve begin, (nc + 1,), of ascending numbers of curves."""
    return np.searchsorted(curve, np.arange(count + 1))


def _across(across: FloatArray, bounds: IntArray) -> tuple[FloatArray, FloatArray]:
    """Largest semi-axis and root mean square of both along every curve, (nc,) each; 0 without samples."""
    largest, square = np.zeros(len(bounds) - 1), np.zeros(len(bounds) - 1)
    filled = np.flatnonzero(np.diff(bounds))
    if len(filled):
        largest[filled] = np.maximum.reduceat(across[:, 0], bounds[filled])
        square[filled] = np.add.reduceat(np.sum(across**2, axis=1), bounds[filled])
    return largest, np.sqrt(square / np.maximum(2 * np.diff(bounds), 1))


def _image_counts(curve: IntArray, image: IntArray, count: int) -> IntArray:
    """Number of images of every curve, (nc,)."""
    images = int(image.max(initial=0)) + 1
    keys = np.unique(curve * images + image)
    return np.bincount(keys // images, minlength=count)


def _segments(cofactors: Cofactors, scale: float) -> SegmentCoefficients:
    """Lee's coefficients of all segments in the user's frame."""
    prepared = cofactors.assembler.prepared
    coefficients, sigma = segment_coefficients(cofactors, scale)
    coefficients[:, 0] += prepared.network.origin
    breaks = [basis.break_points for basis in prepared.curves.bases]
    ends = np.concatenate([np.zeros(0), *(each[1:] for each in breaks)])
    return SegmentCoefficients(np.stack([prepared.curves.left, ends], axis=1), coefficients, sigma)


def _conics(cofactors: Cofactors, scale: float) -> dict[int, ConicElements]:
    """Elements of conics and circles in the user's frame."""
    network = cofactors.assembler.prepared.network
    found = {}
    for k, curve in enumerate(network.curves):
        if curve.family in ("conic", "circle"):
            conic = adjusted_conic(cofactors, k, _own(cofactors, k), scale)
            found[k] = replace(conic, centre=conic.centre + network.origin)
    return found


def _ellipses(cofactors: Cofactors) -> dict[int, Ellipse]:
    """The ellipses nearest to closed curves in the user's frame."""
    prepared = cofactors.assembler.prepared
    found = {}
    for k in np.flatnonzero(prepared.curves.closed).tolist():
        ellipse = nearest_ellipse(prepared.curves.bases[k], _own(cofactors, k))
        found[k] = replace(ellipse, centre=ellipse.centre + prepared.network.origin)
    return found


def _own(cofactors: Cofactors, k: int) -> FloatArray:
    """Coefficients of one curve."""
    start = cofactors.assembler.prepared.curves.coefficient_start
    return cofactors.solution.state.coefficients[int(start[k]) : int(start[k + 1])]
