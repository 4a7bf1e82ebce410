"""The splines of result.json: of all curves at once, so that what is done to numbers is done column by column."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.curve_columns import CurveColumns
from splinebba_cli.core.result import AdjustmentResult, ConicElements, CurveResult
from splinebba_cli.output.json_text import finite


def splines_to_list(result: AdjustmentResult, with_segments: bool) -> list[dict[str, Any]]:
    """One entry a spline, JSON types only: metres; residuals in the photo: mm."""
    columns = CurveColumns.of(result.curves)
    knots, parameters, sigma, along = (
        _parts(column, columns.knot_bounds)
        for column in (columns.knots, columns.knot_parameters, columns.knot_sigma, columns.along_sigma)
    )
    reference = _parts(columns.reference, columns.value_bounds)
    largest, mean, rms = (
        finite(column)
        for column in (columns.sigma_across_max, columns.sigma_across_mean, columns.rms_across_mm)
    )
    images, observations = columns.n_images.tolist(), columns.n_observations.tolist()
    segments = columns.segment_counts.tolist()
    found = []
    for k, given in enumerate(result.network.curves):
        entry = {
            "id": given.id,
            "role": given.role,
            "family": given.family,
            "closed": given.closed,
            "images": images[k],
            "observations": observations[k],
            "knot_parameters": parameters[k],
            "knots": knots[k],
            "knot_sigma": sigma[k],
            "sigma_across": {"max": largest[k], "mean": mean[k]},
            "sigma_along_datum_dependent": along[k],
            "rms_across_mm": rms[k],
            "reference": reference[k],
            "segments": finite(_segments(columns[k])) if with_segments else [],
        }
        with_values = not segments[k] or given.family.startswith("bspline")
        if with_values or k in columns.conics or k in columns.ellipses:
            entry |= finite(_more(columns[k], with_values))
        found.append(entry)
    return found


def _parts(column: FloatArray, bounds: IntArray) -> list[list[Any]]:
    """The rows of every curve as lists."""
    rows, ends = finite(column), bounds.tolist()
    return [rows[begin:end] for begin, end in pairwise(ends)]


def _more(curve: CurveResult, with_values: bool) -> dict[str, Any]:
    """What only some curves have; `with_values`: those whose values are no points of it."""
    found: dict[str, Any] = {}
    if with_values:
        variance = np.einsum("nii->ni", curve.values_dispersion)
        found |= {"values": curve.values, "value_sigma": np.sqrt(np.maximum(variance, 0.0))}
    if curve.conic is not None:
        found["conic"] = _conic(curve.conic)
    if curve.ellipse is not None:
        found["ellipse"] = {
            "centre": curve.ellipse.centre,
            "semi_axes": curve.ellipse.semi_axes,
            "normal": curve.ellipse.normal,
            "rms": curve.ellipse.rms_m,
            "max": curve.ellipse.largest_m,
        }
    return found


def _conic(conic: ConicElements) -> dict[str, Any]:
    return {
        "centre": conic.centre,
        "semi_axes": conic.semi_axes,
        "axes": conic.axes,
        "normal": conic.normal,
        "eccentricity": conic.eccentricity,
        "form": conic.form,
        "sigma": {
            "centre": conic.centre_sigma,
            "semi_axes": conic.semi_axes_sigma,
            "eccentricity": conic.eccentricity_sigma,
            "normal_deg": float(np.degrees(conic.normal_sigma_rad)),
        },
    }


def _segments(curve: CurveResult) -> list[dict[str, Any]]:
    s = curve.segments
    return [
        {
            "interval": s.interval[i],
            **{letter: s.coefficients[i, :, axis] for axis, letter in enumerate("abc")},
            **{f"sigma_{letter}": s.sigma[i, :, axis] for axis, letter in enumerate("abc")},
        }
        for i in range(len(s.interval))
    ]
