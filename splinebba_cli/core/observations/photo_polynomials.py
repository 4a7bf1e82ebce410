"""Curve segments in the frame of a photo, and points measured near them, many at once.

A segment X(t) = sum_k a_k t^k seen from image i is, in its photo frame, another cubic

    p(t) = R'(X(t) - X0) = sum_k q_k t^k,   q_0 = R'(a_0 - X0),  q_k = R' a_k

so that the rotation is done once for a segment and not for every point measured on it.  The tables keep
(-c u, -c v, w), whence x = p_0/p_2, y = p_1/p_2 (theory, section 3).  All arrays here run over points in their last
axis: what is done to all points is then one pass over contiguous memory.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray
from splinebba_cli.core.state import State


def photo_polynomials(
    polynomials: FloatArray, distance: FloatArray, state: State, image: IntArray, segments: IntArray
) -> FloatArray:
    """Coefficients of segments as images see them, (12, g s): three components of q_0, then of q_1, q_2, q_3.

    Parameters
    ----------
    polynomials : (S, 4, 3) of the object frame
    distance : (m,) principal distances of the images, mm
    image : (g,)
    segments : (g, s) segments that each of them sees; column j of row i is at i s + j of the table
    """
    local = polynomials[segments]
    local[:, :, 0] -= state.position[image][:, None]
    to_photo = state.rotation[image].copy()  # p' = X' R
    to_photo[:, :, :2] *= -distance[image][:, None, None]
    seen = np.matmul(local.reshape(len(image), -1, 3), to_photo)
    return np.ascontiguousarray(seen.reshape(-1, 12).T)


@dataclass(frozen=True)
class CurvePlaces:
    """Places of curves in photo frames, scaled as in the tables, (3, n) each."""

    value: FloatArray
    first: FloatArray  # d/dt
    second: FloatArray  # d^2/dt^2


def places_on_segments(table: FloatArray, column: IntArray, t: FloatArray) -> CurvePlaces:
    """Values and derivatives of cubics at t, (n,) each one in its own column of a table."""
    a = np.take(table, column, axis=1, mode="clip")
    tail = t * a[9:]
    inner = a[6:9] + tail
    value = t * inner
    value += a[3:6]
    value *= t
    value += a[:3]
    inner *= 2.0
    first = inner + tail
    first *= t
    first += a[3:6]
    tail *= 4.0
    inner += tail
    return CurvePlaces(value, first, inner)
