"""Known curves before many orientations of one image: places, directions, depths, and what the picture shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.matching.free_orientation.chains import ImageChains
from splinebba_cli.core.matching.free_orientation.places import CurveSamples
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Seen:
    """Samples before orientations (s, 3, 3), (s, 3), component by component; NaN behind the camera."""

    x: FloatArray  # (s, m) mm
    y: FloatArray
    along_x: FloatArray  # (s, m) mm per metre of curve
    along_y: FloatArray
    depth: FloatArray  # (s, m) metres
    inside: BoolArray  # (s, m) in the picture

    def one(self, rows: IntArray) -> tuple[FloatArray, FloatArray]:
        """Places and directions (k, 2) of some samples before the first orientation."""
        xy = np.column_stack([self.x[0, rows], self.y[0, rows]])
        return xy, np.column_stack([self.along_x[0, rows], self.along_y[0, rows]])


def see(chains: ImageChains, samples: CurveSamples, rotation: FloatArray, position: FloatArray) -> Seen:
    """Samples of curves as an image sees them under many orientations."""
    c = chains.principal_distance
    u, v, w = (
        rotation[:, :, k] @ samples.xyz.T - _dot(rotation[:, :, k], position)[:, None] for k in range(3)
    )
    du, dv, dw = (rotation[:, :, k] @ samples.tangent.T for k in range(3))
    depth = np.where(w < 0.0, -w, np.nan)
    factor = 1.0 / depth
    x, y = c * u * factor, c * v * factor
    (left, lower), (right, upper) = chains.format_mm
    with np.errstate(invalid="ignore"):
        inside = (x >= left) & (x <= right) & (y >= lower) & (y <= upper)
    return Seen(x, y, (c * du + x * dw) * factor, (c * dv + y * dw) * factor, depth, inside)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def apart(seen: Seen, k: int) -> FloatArray:
    """How far from each other orientation k and the others see the same places, medians (s,) mm.

    Of the places that either shows in the picture; one that only either has before it is infinitely far.
    """
    away = np.hypot(seen.x - seen.x[k], seen.y - seen.y[k])
    away = np.where(np.isfinite(away), away, np.inf)
    away = np.sort(np.where(seen.inside | seen.inside[k], away, np.nan), axis=1)  # NaN last
    count = np.count_nonzero(~np.isnan(away), axis=1)
    return np.where(count > 0, away[np.arange(len(away)), np.maximum(count - 1, 0) // 2], 0.0)


def across_design(
    principal_distance: float, p: FloatArray, normal: FloatArray, rotation: FloatArray
) -> FloatArray:
    """Derivatives of normal . xy with respect to theta (photo frame) and X0, (k, 6).

    Parameters
    ----------
    p : (k, 3) metres, object points in the photo frame
    normal : (k, 2)
    rotation : (3, 3) or (k, 3, 3) object from photo
    """
    x, y, depth = p[:, 0], p[:, 1], -p[:, 2]
    first, second = (principal_distance * normal / depth[:, None]).T
    third = (first * x + second * y) / depth
    turned = np.stack(
        [second * p[:, 2] - third * y, third * x - first * p[:, 2], first * y - second * x], axis=1
    )
    rate = np.stack([first, second, third], axis=1)[:, None, :]
    return np.hstack([turned, -np.matmul(rate, np.swapaxes(rotation, -1, -2))[:, 0]])
