"""Foot points of some tracks: the kernel of :mod:`foot_points`, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from splinebba_cli.core.observations.photo_segments_compiled import photo_segment, segment_of, wrapped


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _step(q, t, whitening, xy, n, largest):
    """Safeguarded step of Newton's method in t, and the error in sigma that it leaves."""
    p0 = q[0, 0] + t * (q[1, 0] + t * (q[2, 0] + t * q[3, 0]))
    p1 = q[0, 1] + t * (q[1, 1] + t * (q[2, 1] + t * q[3, 1]))
    p2 = q[0, 2] + t * (q[1, 2] + t * (q[2, 2] + t * q[3, 2]))
    d0 = q[1, 0] + t * (2.0 * q[2, 0] + 3.0 * t * q[3, 0])
    d1 = q[1, 1] + t * (2.0 * q[2, 1] + 3.0 * t * q[3, 1])
    d2 = q[1, 2] + t * (2.0 * q[2, 2] + 3.0 * t * q[3, 2])
    inverse = 1.0 / p2
    x, y = p0 * inverse, p1 * inverse
    sx, sy = (d0 - x * d2) * inverse, (d1 - y * d2) * inverse
    e0, e1, e2 = (
        2.0 * q[2, 0] + 6.0 * t * q[3, 0],
        2.0 * q[2, 1] + 6.0 * t * q[3, 1],
        2.0 * q[2, 2] + 6.0 * t * q[3, 2],
    )
    bx = (e0 - x * e2 - 2.0 * sx * d2) * inverse
    by = (e1 - y * e2 - 2.0 * sy * d2) * inverse
    ex, ey = x - xy[n, 0], y - xy[n, 1]
    a, b, c, d = whitening[n, 0, 0], whitening[n, 0, 1], whitening[n, 1, 0], whitening[n, 1, 1]
    r0, r1 = a * ex + b * ey, c * ex + d * ey
    s0, s1 = a * sx + b * sy, c * sx + d * sy
    c0, c1 = a * bx + b * by, c * bx + d * by
    square = s0 * s0 + s1 * s1
    hessian = square + r0 * c0 + r1 * c1
    newton = hessian > 0.2 * square
    step = -(r0 * s0 + r1 * s1) / (hessian if newton else square)
    if not np.isfinite(step):
        step = 0.0
    left = np.sqrt(square) * (step * step if newton else abs(step))
    return min(max(step, -largest), largest), left


@njit(cache=True, nogil=True, error_model="numpy")
def walk_to_feet(
    first_track, last_track, starts, track_image, track_curve, points, free, steps, largest, left_error,
    location, low, high, polynomials, left, length, segment_start, first, last, closed,
    position, rotation, distance, xy, whitening,
):  # fmt: skip
    """Move the locations of free points to their foot points, in place."""
    q = np.empty((4, 3))
    for track in range(first_track, last_track):
        i, curve = track_image[track], track_curve[track]
        begin, end = segment_start[curve], segment_start[curve + 1] - 1
        transformed = -1
        for k in range(starts[track], starts[track + 1]):
            n = points[k]
            if not free[n]:
                continue
            u = location[n]
            s = segment_of(u, left, begin, end)
            for _ in range(steps):
                if closed[curve]:
                    u = wrapped(u, first[curve], last[curve])
                while s < end and u >= left[s] + length[s]:
                    s += 1
                while s > begin and u < left[s]:
                    s -= 1
                if s != transformed:
                    photo_segment(polynomials, s, position, rotation, i, distance[i], q)
                    transformed = s
                step, error = _step(q, (u - left[s]) / length[s], whitening, xy, n, largest)
                moved = min(max(u + step * length[s], low[n]), high[n])
                settled = error < left_error or moved == u
                u = moved
                if settled:
                    break
            location[n] = u
