"""Normal equations of one chunk of measured curve points: the kernel of :mod:`curve_chunk`, compiled.

For every window: its segments in the photo frame, then point by point the row across (and along, where it stays), its
product with itself, and at last the parts of the window where they belong.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from splinebba_cli.core.observations.photo_segments_compiled import photo_segment


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _point_rows(q, t, weights, rotation, distance, whitening, xy, size, count, across, along):
    """Rows across and along at t on a segment q of the photo frame; returns residual along and whether in front."""
    p = np.empty(3)
    d = np.empty(3)
    for k in range(3):
        p[k] = q[0, k] + t * (q[1, k] + t * (q[2, k] + t * q[3, k]))
        d[k] = q[1, k] + t * (2.0 * q[2, k] + 3.0 * t * q[3, k])
    if not p[2] < 0.0:
        return 0.0, False
    inverse = 1.0 / p[2]
    x, y = p[0] * inverse, p[1] * inverse
    sx, sy = (d[0] - x * d[2]) * inverse, (d[1] - y * d[2]) * inverse
    ex, ey = x - xy[0], y - xy[1]
    r0, r1 = whitening[0, 0] * ex + whitening[0, 1] * ey, whitening[1, 0] * ex + whitening[1, 1] * ey
    b0, b1 = whitening[0, 0] * sx + whitening[0, 1] * sy, whitening[1, 0] * sx + whitening[1, 1] * sy
    speed = np.sqrt(b0 * b0 + b1 * b1)
    if speed > 0.0:
        b0, b1 = b0 / speed, b1 / speed
    else:
        b0, b1 = 0.0, 1.0
    residual = b0 * r0 + b1 * r1
    _project(-b1, b0, p, x, y, inverse, t, weights, rotation, distance, whitening, size, count, across)
    across[size + 3 * count] = b0 * r1 - b1 * r0
    _project(b0, b1, p, x, y, inverse, t, weights, rotation, distance, whitening, size, count, along)
    along[size + 3 * count] = residual
    return residual, True


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _project(n0, n1, p, x, y, inverse, t, weights, rotation, distance, whitening, size, count, row):
    """Derivatives of the residual along (n0, n1) over orientation and coefficients."""
    m0 = n0 * whitening[0, 0] + n1 * whitening[1, 0]
    m1 = n0 * whitening[0, 1] + n1 * whitening[1, 1]
    h2 = -(m0 * x + m1 * y) * inverse
    h0, h1 = -distance * m0 * inverse, -distance * m1 * inverse
    u, v, w = -p[0] / distance, -p[1] / distance, p[2]
    g0 = rotation[0, 0] * h0 + rotation[0, 1] * h1 + rotation[0, 2] * h2
    g1 = rotation[1, 0] * h0 + rotation[1, 1] * h1 + rotation[1, 2] * h2
    g2 = rotation[2, 0] * h0 + rotation[2, 1] * h1 + rotation[2, 2] * h2
    if size > 0:
        row[0], row[1], row[2] = h1 * w - h2 * v, h2 * u - h0 * w, h0 * v - h1 * u
        row[3], row[4], row[5] = -g0, -g1, -g2
    for j in range(count):
        n = weights[0, j] + t * (weights[1, j] + t * (weights[2, j] + t * weights[3, j]))
        k = size + 3 * j
        row[k], row[k + 1], row[k + 2] = n * g0, n * g1, n * g2


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _add_product(row, window):
    """Upper triangle of window += row row'."""
    for i in range(len(row)):
        a = row[i]
        for j in range(i, len(row)):
            window[i, j] += a * row[j]


@njit(cache=True, nogil=True, error_model="numpy")
def chunk_sums(
    first_window, last_window, starts, image, points, segment, t, polynomials, weights, count, size,
    position, rotation, distance, xy, whitening, held, free_along, unsettled, mask, spans, target, alone,
    values, shared, image_slot, image_side, curve_slot, curve_side, across, along, kept,
):  # fmt: skip
    """Sums of the windows of a chunk; False where a point lies behind a camera.

    Parameters
    ----------
    starts : (G + 1,) first point of every window
    mask : (g, P) or (0, 0)
    spans : (parts, 4) first and last row and column of every part
    target : (parts, g) where the block of a window begins, in `values` or in `shared`
    alone : (parts,) whether it is in `values`
    """
    width = size + 3 * count + 1
    window = np.empty((width, width))
    row, other, q = np.empty(width), np.empty(width), np.empty((4, 3))
    for g in range(first_window, last_window):
        i = image[g]
        window[:] = 0.0
        last = -1
        for k in range(starts[g], starts[g + 1]):
            n = points[k]
            s = segment[n]
            if s != last:
                photo_segment(polynomials[s], position[i], rotation[i], distance[i], q)
                last = s
            residual, front = _point_rows(
                q, t[n], weights[s], rotation[i], distance[i], whitening[n], xy[n], size, count, row, other
            )
            if not front:
                return False
            across[n], along[n] = row[width - 1], residual
            _add_product(row, window)
            stays = free_along[k] and (held[n] or abs(residual) > unsettled)
            kept[n] = stays
            if stays:
                _add_product(other, window)
        local = g - first_window
        if len(mask):
            for a in range(width):
                for b in range(a, width):
                    window[a, b] *= (mask[local, a] if a < width - 1 else 1.0) * (
                        mask[local, b] if b < width - 1 else 1.0
                    )
        _store(window, local, spans, target, alone, values, shared)
        for a in range(size):
            image_side[image_slot[local], a] -= window[a, width - 1]
        for a in range(3 * count):
            curve_side[curve_slot[local], a] -= window[size + a, width - 1]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _store(window, local, spans, target, alone, values, shared):
    """Add the parts of a window to their targets."""
    for part in range(len(spans)):
        out = values if alone[part] else shared
        place = target[part, local]
        for a in range(spans[part, 0], spans[part, 1]):
            for b in range(spans[part, 2], spans[part, 3]):
                out[place] += window[min(a, b), max(a, b)]
                place += 1
