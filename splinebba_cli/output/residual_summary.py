"""Residuals in few numbers: count, root mean square and largest, per kind, group of the project, image and spline.

    image points of points    per coordinate: rms = sqrt(Σ (v_x² + v_y²) / 2n), max = largest |v_x| or |v_y|
    image points on splines   across the curve: rms = sqrt(Σ v_n² / n), max = largest |v_n|
    arc lengths, tangents     rms = sqrt(Σ v² / n), max = largest |v|, mm or degrees
    distances                 the same in metres

The along-curve part of an image point on a spline is taken up by its own location and says nothing.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from splinebba_cli.core.evidence import ObservationKind, Reliability
from splinebba_cli.core.network import (
    CurveObservations,
    FloatArray,
    IntArray,
    PointObservations,
    select_rows,
)
from splinebba_cli.core.prior_residuals import PriorResiduals
from splinebba_cli.core.result import AdjustmentResult
from splinebba_cli.output.revision_tables import weights_of

Summary = dict[str, Any]
_TABLES: tuple[tuple[ObservationKind, str, str], ...] = (
    ("point", "point_observations", "point_residuals"),
    ("spline", "curve_observations", "curve_residuals"),
    ("arc length", "arc_lengths", "arc_residuals"),
    ("tangent", "tangents", "tangent_residuals"),
    ("distance", "distances", "distance_residuals"),
)  # and the attributes of a network and a result


def residual_summary(result: AdjustmentResult) -> Summary:
    """The ``residuals`` part of result.json: mm in the photo, and px where a pixel size is known."""
    result = taking_part(result)
    pixel = _pixel_sizes(result)
    points, curves = result.network.point_observations, result.network.curve_observations
    point_v, across = result.point_residuals.residual, result.curve_residuals.across[:, None]
    point_pixel, curve_pixel = pixel[points.image], pixel[curves.image]
    images = range(len(result.network.images.ids))
    by_image = _per_index(point_v, point_pixel, points.image, len(images))
    curves_by_image = _per_index(across, curve_pixel, curves.image, len(images))
    by_curve = _per_index(across, curve_pixel, curves.curve, len(result.curves))
    point_redundancy, curve_redundancy = result.point_residuals.redundancy, result.curve_residuals.redundancy
    return {
        "sign": "adjusted - measured",
        "kinds": [
            _kind("points", point_v, point_pixel, point_redundancy),
            _kind("splines", across, curve_pixel, curve_redundancy),
        ],
        "groups": [
            *_groups("points", points, point_v, point_pixel, point_redundancy),
            *_groups("splines", curves, across, curve_pixel, curve_redundancy),
        ],
        "linked": _linked(result),
        "priors": _prior_groups(result.prior_residuals),
        "images": [
            {"id": result.network.images.ids[i], "points": by_image[i], "splines": curves_by_image[i]}
            for i in images
        ],
        "splines": [
            {"id": curve.id, **summary}
            for curve, summary in zip(result.network.curves, by_curve, strict=True)
        ],
    }


def taking_part(result: AdjustmentResult) -> AdjustmentResult:
    """The result without the residuals of observations that are out: they are predictions, not residuals."""
    network, changes = result.network, {}
    observed: dict[str, Any] = {}
    for kind, group, table in _TABLES:
        weight = weights_of(result, kind)
        if (weight > 0.0).all():
            continue
        rows = np.flatnonzero(weight > 0.0)
        changes[table] = _rows(getattr(result, table), rows)
        observed[group] = select_rows(getattr(network, group), rows)
    return replace(result, network=replace(network, **observed), **changes)


def _rows(table: Any, rows: IntArray) -> Any:
    """Some rows of a table of residuals and of its reliability."""
    columns = {each.name: getattr(table, each.name) for each in fields(table)}
    taken = {
        name: _rows(values, rows) if isinstance(values, Reliability) else values[rows]
        for name, values in columns.items()
    }
    return replace(table, **taken)


def _pixel_sizes(result: AdjustmentResult) -> FloatArray:
    """Pixel size of every image in mm, NaN where unknown, (m,)."""
    sizes = np.array([camera.pixel_size_mm or np.nan for camera in result.network.cameras], dtype=float)
    return sizes[result.network.images.camera]


def _kind(kind: str, residual_mm: FloatArray, pixel_mm: FloatArray, redundancy: FloatArray) -> Summary:
    """Summary of image points of one kind, with the number of residuals each has and their redundancy."""
    summary = _summary(residual_mm, pixel_mm)
    return {
        "kind": kind,
        "coordinates": residual_mm.shape[1],
        **summary,
        "redundancy": float(np.nansum(redundancy)),
    }


def _groups(
    kind: str,
    observed: PointObservations | CurveObservations,
    residual_mm: FloatArray,
    pixel_mm: FloatArray,
    redundancy: FloatArray,
) -> list[Summary]:
    """Summary of every group of observations of the project, by the name that it has there."""
    if observed.group is None:
        return [{"group": kind, **_kind(kind, residual_mm, pixel_mm, redundancy)}] if len(observed) else []
    rows = _rows_of(observed.group, len(observed.group_names))
    return [
        {"group": name, **_kind(kind, residual_mm[row], pixel_mm[row], redundancy[row])}
        for name, row in zip(observed.group_names, rows, strict=True)
    ]


def _summary(residual_mm: FloatArray, pixel_mm: FloatArray) -> Summary:
    """Summary of residuals (n, 1 or 2) with the pixel size of each (n,)."""
    if not residual_mm.size:
        return {"n": 0, "rms_mm": None, "max_mm": None, "rms_px": None, "max_px": None}
    pixels = residual_mm / pixel_mm[:, None]
    return {
        "n": len(residual_mm),
        "rms_mm": float(np.sqrt(np.mean(residual_mm**2))),
        "max_mm": float(np.max(np.abs(residual_mm))),
        "rms_px": float(np.sqrt(np.mean(pixels**2))),
        "max_px": float(np.max(np.abs(pixels))),
    }


def _per_index(residual_mm: FloatArray, pixel_mm: FloatArray, index: IntArray, count: int) -> list[Summary]:
    """The summary of every image or spline."""
    if not residual_mm.size:
        return [_summary(residual_mm, pixel_mm) for _ in range(count)]
    n = np.bincount(index, minlength=count)
    order = np.argsort(index, kind="stable")
    seen = np.flatnonzero(n)
    starts = np.cumsum(n)[seen] - n[seen]
    columns = [n]
    for values in (residual_mm, residual_mm / pixel_mm[:, None]):
        size = np.abs(values[order])
        rms, largest = np.full((2, count), np.nan)
        rms[seen] = np.sqrt(np.add.reduceat((size**2).sum(axis=1), starts) / (n[seen] * size.shape[1]))
        largest[seen] = np.maximum.reduceat(size.max(axis=1), starts)
        columns += [rms, largest]
    names = ("n", "rms_mm", "max_mm", "rms_px", "max_px")
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return [dict(zip(names, row, strict=True)) for row in rows]


def _rows_of(index: IntArray, count: int) -> list[IntArray]:
    """The rows in which `index` is 0, 1, … count - 1."""
    order = np.argsort(index, kind="stable")
    bounds = np.searchsorted(index[order], np.arange(count + 1))
    return [order[bounds[i] : bounds[i + 1]] for i in range(count)]


def _linked(result: AdjustmentResult) -> list[Summary]:
    """Per group of arc lengths (mm), tangents (degrees), distances (m): count, rms, largest, redundancy."""
    out = []
    for kind, unit, factor, observed, found in (
        ("arc lengths", "mm", 1.0, result.network.arc_lengths, result.arc_residuals),
        ("tangents", "deg", 180.0 / np.pi, result.network.tangents, result.tangent_residuals),
        ("distances", "m", 1.0, result.network.distances, result.distance_residuals),
    ):
        if not len(observed):
            continue
        names = observed.group_names or (kind,)
        group = np.zeros(len(observed), dtype=np.int64) if observed.group is None else observed.group
        for name, rows in zip(names, _rows_of(group, len(names)), strict=True):
            head = {"group": name, "kind": kind, "unit": unit}
            out.append({**head, **_scalar_summary(factor * found.residual[rows], found.redundancy[rows])})
    return out


def _scalar_summary(values: FloatArray, redundancy: FloatArray) -> Summary:
    """Count, root mean square, largest and redundancy of residuals (n,); null where there are none."""
    return {
        "n": len(values),
        "rms": float(np.sqrt(np.mean(values**2))) if len(values) else None,
        "max": float(np.max(np.abs(values))) if len(values) else None,
        "redundancy": float(np.sum(redundancy)),
    }


def _prior_groups(priors: PriorResiduals) -> list[Summary]:
    """Per kind and unit (degrees or metres), in order of appearance: count, rms, largest, redundancy."""
    return [
        {
            "kind": kind,
            "unit": "deg" if angular else "m",
            **_scalar_summary(
                priors.residual[rows] * (180.0 / np.pi if angular else 1.0), priors.redundancy[rows]
            ),
        }
        for kind, angular, rows in priors.groups()
    ]
