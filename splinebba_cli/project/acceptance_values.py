"""The figures of a result that acceptance criteria limit, each with the worst subject."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.quality.observation_names import distance_name
from splinebba_cli.core.result import AdjustmentResult


@dataclass(frozen=True)
class Found:
    """A figure; None where there is nothing to take it from."""

    value: float | None
    subject: str = ""  # "image `762`"
    detail: str = ""  # " in Z"


NOTHING = Found(None)


def sigma0(result: AdjustmentResult) -> Found:
    """A-posteriori standard deviation of unit weight."""
    value = result.statistics.sigma0
    return Found(value) if np.isfinite(value) else NOTHING


def standardized(result: AdjustmentResult) -> Found:
    """Largest |w|, or |tau| = |w| sigma0_prior / sigma0, of image coordinates, arc lengths, tangents and distances."""
    network, statistics = result.network, result.statistics
    scale = 1.0
    if network.settings.testing.statistic == "tau":
        scale = statistics.sigma0_prior / statistics.sigma0
    best = NOTHING
    for kind, values, image, feature, ids in _of_images(result, "standardized"):
        size = np.abs(values)
        size = np.where(np.isfinite(size), size, -1.0)
        largest = size.max(axis=1, initial=-1.0)
        if not len(largest) or largest.max() < 0.0:
            continue
        row = int(np.argmax(largest))
        if best.value is None or largest[row] * scale > best.value:
            best = Found(
                float(largest[row]) * scale,
                f"{kind} `{ids[feature[row]]}` in image `{network.images.ids[image[row]]}`",
            )
    distances = np.nan_to_num(np.abs(result.distance_residuals.standardized)) * scale
    if result.revision.distance_weights is not None:
        distances = np.where(result.revision.distance_weights > 0.0, distances, 0.0)
    if len(distances) and distances.max() > (best.value or 0.0):
        best = Found(float(distances.max()), distance_name(network, int(np.argmax(distances))))
    return best


def smallest_redundancy(result: AdjustmentResult) -> Found:
    """Smallest redundancy number of the observations that take part, and whose it is."""
    numbers = _redundancy(result)
    if not len(numbers):
        return NOTHING
    parts = _of_images(result, "redundancy")
    size = [float(np.nanmin(part[1])) if np.isfinite(part[1]).any() else np.inf for part in parts]
    least = int(np.argmin(size))
    detail = f" (of {len(numbers)})"
    distances = _taking_part(result.distance_residuals.redundancy[:, None], result.revision.distance_weights)
    if np.isfinite(distances).any() and np.nanmin(distances) < size[least]:
        row = int(np.nanargmin(distances))
        return Found(float(distances[row, 0]), distance_name(result.network, row), detail)
    kind, values, image, feature, ids = parts[least]
    row = int(np.argmin(np.where(np.isfinite(values), values, np.inf).min(axis=1)))
    subject = f"{kind} `{ids[feature[row]]}` in image `{result.network.images.ids[image[row]]}`"
    return Found(size[least], subject, detail)


def mean_redundancy(result: AdjustmentResult) -> Found:
    """Mean redundancy number of the observations that take part."""
    numbers = _redundancy(result)
    return Found(float(numbers.mean())) if len(numbers) else NOTHING


def rejected_share(result: AdjustmentResult) -> Found:
    """Rejected observations over all of them."""
    network = result.network
    linked = (network.arc_lengths, network.tangents, network.distances)
    parts = (network.point_observations, network.curve_observations, *linked)
    count = sum(len(part) for part in parts)
    return Found(result.revision.rejected / count) if count else NOTHING


def check_count(result: AdjustmentResult) -> Found:
    """Number of check points."""
    return Found(float(len(result.checks.points)))


def check_rmse(result: AdjustmentResult) -> Found:
    """Largest of the RMSE in X, Y and Z."""
    rmse = _rmse(result)
    if rmse is None:
        return NOTHING
    axis = int(np.argmax(rmse))
    return Found(float(rmse[axis]), detail=f" in {'XYZ'[axis]}")


def check_rmse_horizontal(result: AdjustmentResult) -> Found:
    """Horizontal RMSE of the check points."""
    rmse = _rmse(result)
    return NOTHING if rmse is None else Found(float(np.hypot(rmse[0], rmse[1])))


def check_rmse_vertical(result: AdjustmentResult) -> Found:
    """Vertical RMSE of the check points."""
    rmse = _rmse(result)
    return NOTHING if rmse is None else Found(float(rmse[2]))


def check_spline_rms(result: AdjustmentResult) -> Found:
    """Largest RMS distance of a check spline."""
    splines = result.checks.splines
    if not splines:
        return NOTHING
    worst = max(splines, key=lambda spline: np.nan_to_num(spline.rms, nan=np.inf))
    return Found(worst.rms, f"check spline `{worst.id}`")


def position_sigma(result: AdjustmentResult) -> Found:
    """Largest standard deviation of a coordinate of a perspective centre, m."""
    return _worst(result.images.dispersion[:, 3:, 3:], result.network.images.ids, "image")


def angle_sigma(result: AdjustmentResult) -> Found:
    """Largest standard deviation of an angle, degrees."""
    return _worst(
        result.images.dispersion[:, :3, :3] * np.degrees(1.0) ** 2, result.network.images.ids, "image"
    )


def point_sigma(result: AdjustmentResult) -> Found:
    """Largest standard deviation of a coordinate of a tie or check point, m."""
    points = result.network.points
    rows = np.flatnonzero([role != "control" for role in points.role])
    return _worst(result.points.dispersion[rows], tuple(points.ids[row] for row in rows), "point")


def sigma_across(result: AdjustmentResult) -> Found:
    """Largest standard deviation across an estimated curve, m."""
    pairs = zip(result.network.curves, result.curves, strict=True)
    found = [(curve.sigma_across_max, given.id) for given, curve in pairs if given.role != "control"]
    if not found:
        return NOTHING
    value, name = max(found)
    return Found(float(value), f"spline `{name}`")


def _worst(dispersion: FloatArray, ids: tuple[str, ...], kind: str) -> Found:
    if not len(ids):
        return NOTHING
    sigma = np.sqrt(np.maximum(np.einsum("nii->ni", dispersion), 0.0)).max(axis=1)
    row = int(np.argmax(np.nan_to_num(sigma, nan=np.inf)))
    return Found(float(sigma[row]), f"{kind} `{ids[row]}`")


def _rmse(result: AdjustmentResult) -> FloatArray | None:
    differences = np.array([point.difference for point in result.checks.points]).reshape(-1, 3)
    return np.sqrt(np.mean(differences**2, axis=0)) if len(differences) else None


def _redundancy(result: AdjustmentResult) -> FloatArray:
    """Redundancy numbers of image coordinates (of curves: across), arc lengths, tangents, distances that take part."""
    revision = result.revision
    parts = (
        (result.point_residuals.redundancy, revision.point_weights),
        (result.curve_residuals.redundancy[:, :1], revision.curve_weights),
        (result.arc_residuals.redundancy[:, None], revision.arc_weights),
        (result.tangent_residuals.redundancy[:, None], revision.tangent_weights),
        (result.distance_residuals.redundancy[:, None], revision.distance_weights),
    )
    kept = [numbers if weights is None else numbers[weights > 0.0] for numbers, weights in parts]
    return np.concatenate([numbers.ravel() for numbers in kept])


OfImages = tuple[str, FloatArray, IntArray, IntArray, Sequence[str]]


def _of_images(result: AdjustmentResult, figure: Literal["standardized", "redundancy"]) -> list[OfImages]:
    """Kind, a figure (NaN of what takes no part), image, feature and the ids of the features; of splines: across."""
    network, revision = result.network, result.revision
    points, curves = network.point_observations, network.curve_observations
    curve_ids = [curve.id for curve in network.curves]
    arc, tangent = network.arc_lengths.first, network.tangents.point
    of_curves: FloatArray = getattr(result.curve_residuals, figure)
    parts: tuple[tuple[str, FloatArray, IntArray, IntArray, Sequence[str], FloatArray | None], ...] = (
        ("point", getattr(result.point_residuals, figure), points.image, points.point, network.points.ids,
         revision.point_weights),
        ("spline", of_curves if figure == "standardized" else of_curves[:, :1], curves.image, curves.curve, curve_ids,
         revision.curve_weights),
        ("arc length of spline", getattr(result.arc_residuals, figure)[:, None], curves.image[arc],
         curves.curve[arc], curve_ids, revision.arc_weights),
        ("tangent of spline", getattr(result.tangent_residuals, figure)[:, None], curves.image[tangent],
         curves.curve[tangent], curve_ids, revision.tangent_weights),
    )  # fmt: skip
    return [
        (kind, _taking_part(values, weights), image, feature, ids)
        for kind, values, image, feature, ids, weights in parts
    ]


def _taking_part(values: FloatArray, weights: FloatArray | None) -> FloatArray:
    """Values (n, k), NaN in the rows that take no part."""
    return values if weights is None else np.where((weights > 0.0)[:, None], values, np.nan)
