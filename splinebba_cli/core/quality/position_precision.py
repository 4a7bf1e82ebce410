"""Standard ellipses and ellipsoids of perspective centres and points, and their uncertainty with a confidence.

Horizontal ellipse of the dispersion C of (X, Y), with m = (c_xx + c_yy) / 2, h^2 = ((c_xx - c_yy) / 2)^2 + c_xy^2,

    a^2 = m + h,   b^2 = m - h,   azimuth of a from Y clockwise = pi / 2 - atan2(2 c_xy, c_xx - c_yy) / 2

(Helmert); the ellipsoid has the eigenvectors of C as axes.  Factors and circles: confidence.py.
"""

from __future__ import annotations

import numpy as np

from splinebba_cli.core.evidence import ErrorEllipses, Precision
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.quality.confidence import circular_radius, confidence_factor
from splinebba_cli.core.quality.high_correlations import high_correlations
from splinebba_cli.core.quality.variance_factor import variance_degrees
from splinebba_cli.core.result import AdjustmentResult


def position_precision(result: AdjustmentResult) -> Precision:
    """Precision of all positions of a result at the confidence of its settings."""
    settings = result.network.settings
    degrees = variance_degrees(settings, result.statistics)
    found, count = high_correlations(result, settings.correlation_threshold)
    network = result.network
    return Precision(
        confidence=settings.confidence,
        degrees=degrees,
        interval_factor=confidence_factor(1, settings.confidence, degrees),
        ellipse_factor=confidence_factor(2, settings.confidence, degrees),
        ellipsoid_factor=confidence_factor(3, settings.confidence, degrees),
        images=error_ellipses(
            network.images.ids, result.images.dispersion[:, 3:, 3:], settings.confidence, degrees
        ),
        points=error_ellipses(network.points.ids, result.points.dispersion, settings.confidence, degrees),
        correlations=found,
        correlations_found=count,
        correlation_threshold=settings.correlation_threshold,
    )


def error_ellipses(
    ids: tuple[str, ...], dispersion: FloatArray, confidence: float, degrees: float | None
) -> ErrorEllipses:
    """Ellipses of positions with dispersions (n, 3, 3), m², in the object frame."""
    semi_axes, azimuth = horizontal_ellipses(dispersion[:, :2, :2])
    values, vectors = np.linalg.eigh(dispersion)
    vertical = np.sqrt(np.maximum(dispersion[:, 2, 2], 0.0))
    return ErrorEllipses(
        ids=ids,
        semi_axes_m=semi_axes,
        azimuth_rad=azimuth,
        ellipsoid_m=np.sqrt(np.maximum(values[:, ::-1], 0.0)),
        ellipsoid_axes=np.ascontiguousarray(vectors[:, :, ::-1].transpose(0, 2, 1)),
        horizontal_m=circular_radius(semi_axes, confidence, degrees),
        vertical_m=vertical * confidence_factor(1, confidence, degrees),
    )


def horizontal_ellipses(dispersion: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Semi-axes (n, 2), larger first, and azimuth of the larger one (n,) of dispersions (n, 2, 2) of X, Y."""
    xx, yy, xy = dispersion[:, 0, 0], dispersion[:, 1, 1], dispersion[:, 0, 1]
    mean, half = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    major = mean + half
    determinant = np.maximum(xx * yy - xy**2, 0.0)
    minor = np.where(major > 0.0, determinant / np.where(major > 0.0, major, 1.0), 0.0)  # m - h cancels
    azimuth = np.mod(0.5 * np.pi - 0.5 * np.arctan2(2.0 * xy, xx - yy), np.pi)
    return np.sqrt(np.stack([np.maximum(major, 0.0), minor], axis=1)), azimuth
