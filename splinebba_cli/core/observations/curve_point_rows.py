"""Equations across curves of many measured points at once, point by point in the last axis.

The same equations as :mod:`~splinebba_cli.core.observations.curve_points`, for assembly: with the place p of the
curve in the photo frame, m = n'W, h = -(1/w) (c m_0, c m_1, m . xy) = d(across)/dp,

    d/dtheta = h x p as a row,   d/dX = g = R h,   d/dX0 = -g,   d/dP_j = N_j g
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.measured_rays import MeasuredRays
from splinebba_cli.core.network import FloatArray
from splinebba_cli.core.observations.photo_polynomials import CurvePlaces


@dataclass(frozen=True)
class PointDirections:
    """Residuals of measured points in the directions of the curve, whitened, and what projects on them."""

    across: FloatArray  # (n,)
    along: FloatArray  # (n,)
    speed: FloatArray  # (n,) per unit of t
    unit: FloatArray  # (2, n) along the curve
    xy: FloatArray  # (2, n) mm, places of the curve
    inverse: FloatArray  # (n,) 1/w

    @classmethod
    def of(cls, places: CurvePlaces, rays: MeasuredRays) -> PointDirections:
        """At places on curves.

        Raises
        ------
        FloatingPointError
            If a place is in or behind the photo plane.
        """
        w = places.value[2]
        if not (w < 0.0).all():
            raise FloatingPointError("a curve point lies behind a camera")
        inverse = 1.0 / w
        xy = places.value[:2] * inverse
        slope = places.first[:2] - xy * places.first[2]
        slope *= inverse
        r, b = rays.whitened(xy - rays.xy), rays.whitened(slope)
        speed = np.sqrt(b[0] * b[0] + b[1] * b[1])
        if speed.all():
            b /= speed
        else:  # a curve that is a point
            still = speed == 0.0
            b /= np.where(still, 1.0, speed)
            b[1, still] = 1.0
        across = b[0] * r[1] - b[1] * r[0]
        along = b[0] * r[0] + b[1] * r[1]
        return cls(across, along, speed, b, xy, inverse)

    def gradients(self, rays: MeasuredRays, direction: FloatArray) -> FloatArray:
        """d/dp of the residual along a direction (2, n), for p scaled as in the tables, (3, n)."""
        h = np.empty((3, len(self.inverse)))
        h[:2] = rays.transposed(direction)
        h[2] = -(h[0] * self.xy[0] + h[1] * self.xy[1])
        h *= self.inverse
        return h


def orientation_rows(h: FloatArray, p: FloatArray, out: FloatArray) -> None:
    """d/dtheta = h x p as a row, into (3, n).

    Parameters
    ----------
    h : (3, n) d/dp
    p : (3, n) places in the photo frame, metres
    """
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(h[i], p[j], out=out[k])
        out[k] -= h[j] * p[i]


def object_rows(h: FloatArray, rotation: FloatArray, out: FloatArray) -> None:
    """d/dX = R h, into (3, n).

    Parameters
    ----------
    rotation : (3, 3, n) object from photo
    """
    for k in range(3):
        np.multiply(rotation[k, 0], h[0], out=out[k])
        out[k] += rotation[k, 1] * h[1]
        out[k] += rotation[k, 2] * h[2]
