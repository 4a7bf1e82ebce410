"""Normal equations of one chunk of measured curve points: the kernel of :mod:`curve_chunk`, compiled.

For every window: its segments in the photo frame, then point by point the row across (and along, where it stays), its
product with itself, and at last the parts of the window where they belong.  Rows are padded to whole vectors.
What is done to a point stands in both kernels: as a function of its own it makes them a fifth to twice as slow.
"""

from __future__ import annotations

import numpy as np
from numba import njit, uintp

from splinebba_cli.core.observations.photo_segments_compiled import photo_segment, segment_of, wrapped

LANES = uintp(8)
"""Numbers of the widest vector register; unsigned, as are indices of inner loops, which then cannot be negative."""
ROWS = 4
"""Rows whose products are added at a time."""


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _directions(q, t, whitening, xy, n, p, out):
    """Place p in the photo frame; into out: x, y, the unit vector along, residuals across and along.

    Returns whether the place is in front of the camera.
    """
    d0 = q[1, 0] + t * (2.0 * q[2, 0] + 3.0 * t * q[3, 0])
    d1 = q[1, 1] + t * (2.0 * q[2, 1] + 3.0 * t * q[3, 1])
    d2 = q[1, 2] + t * (2.0 * q[2, 2] + 3.0 * t * q[3, 2])
    for k in range(3):
        p[k] = q[0, k] + t * (q[1, k] + t * (q[2, k] + t * q[3, k]))
    if not p[2] < 0.0:
        return False
    inverse = 1.0 / p[2]
    x, y = p[0] * inverse, p[1] * inverse
    sx, sy = (d0 - x * d2) * inverse, (d1 - y * d2) * inverse
    ex, ey = x - xy[n, 0], y - xy[n, 1]
    r0, r1 = (
        whitening[n, 0, 0] * ex + whitening[n, 0, 1] * ey,
        whitening[n, 1, 0] * ex + whitening[n, 1, 1] * ey,
    )
    b0, b1 = (
        whitening[n, 0, 0] * sx + whitening[n, 0, 1] * sy,
        whitening[n, 1, 0] * sx + whitening[n, 1, 1] * sy,
    )
    speed = np.sqrt(b0 * b0 + b1 * b1)
    if speed > 0.0:
        b0, b1 = b0 / speed, b1 / speed
    else:
        b0, b1 = 0.0, 1.0
    out[0], out[1], out[2], out[3] = x, y, b0, b1
    out[4], out[5] = b0 * r1 - b1 * r0, b0 * r0 + b1 * r1
    return True


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _project(n0, n1, p, x, y, basis, rotation, image, distance, whitening, point, size, count, rows, line):
    """Derivatives of the residual along (n0, n1) over orientation and coefficients."""
    inverse = 1.0 / p[2]
    m0 = n0 * whitening[point, 0, 0] + n1 * whitening[point, 1, 0]
    m1 = n0 * whitening[point, 0, 1] + n1 * whitening[point, 1, 1]
    h2 = -(m0 * x + m1 * y) * inverse
    h0, h1 = -distance * m0 * inverse, -distance * m1 * inverse
    u, v, w = -p[0] / distance, -p[1] / distance, p[2]
    g0 = rotation[image, 0, 0] * h0 + rotation[image, 0, 1] * h1 + rotation[image, 0, 2] * h2
    g1 = rotation[image, 1, 0] * h0 + rotation[image, 1, 1] * h1 + rotation[image, 1, 2] * h2
    g2 = rotation[image, 2, 0] * h0 + rotation[image, 2, 1] * h1 + rotation[image, 2, 2] * h2
    if size > 0:
        rows[line, 0], rows[line, 1], rows[line, 2] = h1 * w - h2 * v, h2 * u - h0 * w, h0 * v - h1 * u
        rows[line, 3], rows[line, 4], rows[line, 5] = -g0, -g1, -g2
    k = uintp(size)
    for j in range(uintp(count)):
        n = basis[j]
        rows[line, k], rows[line, k + uintp(1)], rows[line, k + uintp(2)] = n * g0, n * g1, n * g2
        k += uintp(3)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def _add_products(rows, width, window):
    """Window += sum row row' of four rows, upper triangle and what completes its vectors."""
    padded = uintp(window.shape[1])
    for i in range(uintp(width)):
        a, b, c, d = rows[0, i], rows[1, i], rows[2, i], rows[3, i]
        for j in range(i // LANES * LANES, padded):
            window[i, j] += a * rows[0, j] + b * rows[1, j] + c * rows[2, j] + d * rows[3, j]


@njit(cache=True, nogil=True, error_model="numpy")
def chunk_sums(
    first_window, last_window, starts, image, curve, points, location, polynomials, left, length, segment_start,
    first, last, closed, weights, count, size,
    position, rotation, distance, xy, whitening, held, free_along, unsettled, mask, spans, target, alone,
    values, shared, image_slot, image_side, curve_slot, curve_side, across, along, kept,
):  # fmt: skip
    """Sums of the windows of a chunk; False where a point lies behind a camera.

    Parameters
    ----------
    starts : (G + 1,) first point of every window
    curve : (G,) of every window
    mask : (g, P) or (0, 0)
    spans : (parts, 4) first and last row and column of every part
    target : (parts, g) where the block of a window begins, in `values` or in `shared`
    alone : (parts,) whether it is in `values`
    """
    width = size + 3 * count + 1
    padded = (width + 7) // 8 * 8
    window, rows = np.empty((width, padded)), np.zeros((ROWS, padded))
    q, p, found, basis = np.empty((4, 3)), np.empty(3), np.empty(6), np.empty(count)
    for g in range(first_window, last_window):
        i, c = image[g], curve[g]
        begin, end = segment_start[c], segment_start[c + 1] - 1
        window[:] = 0.0
        present, filled = -1, 0
        for k in range(starts[g], starts[g + 1]):
            n = points[k]
            u = wrapped(location[n], first[c], last[c]) if closed[c] else location[n]
            s = present if present >= 0 and left[present] <= u < left[present] + length[present] else -1
            if s < 0:
                s = segment_of(u, left, begin, end)
            at = (u - left[s]) / length[s]
            if s != present:
                photo_segment(polynomials, s, position, rotation, i, distance[i], q)
                present = s
            if not _directions(q, at, whitening, xy, n, p, found):
                return False
            x, y, b0, b1 = found[0], found[1], found[2], found[3]
            for j in range(count):
                basis[j] = weights[s, 0, j] + at * (
                    weights[s, 1, j] + at * (weights[s, 2, j] + at * weights[s, 3, j])
                )
            _project(
                -b1, b0, p, x, y, basis, rotation, i, distance[i], whitening, n, size, count, rows, filled
            )
            across[n], along[n] = found[4], found[5]
            rows[filled, width - 1] = found[4]
            filled += 1
            stays = free_along[k] and (held[n] or abs(found[5]) > unsettled)
            kept[n] = stays
            if filled == ROWS:
                _add_products(rows, width, window)
                filled = 0
            if stays:
                _project(
                    b0, b1, p, x, y, basis, rotation, i, distance[i], whitening, n, size, count, rows, filled
                )
                rows[filled, width - 1] = found[5]
                filled += 1
                if filled == ROWS:
                    _add_products(rows, width, window)
                    filled = 0
        if filled > 0:
            for line in range(filled, ROWS):
                for j in range(padded):
                    rows[line, j] = 0.0
            _add_products(rows, width, window)
        local = g - first_window
        if len(mask):
            _take_out(mask[local], window)
        _store(window, local, spans, target, alone, values, shared)
        for a in range(size):
            image_side[image_slot[local], a] -= window[a, width - 1]
        for a in range(3 * count):
            curve_side[curve_slot[local], a] -= window[size + a, width - 1]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def chunk_sides(
    first_window, last_window, starts, image, curve, points, location, polynomials, left, length, segment_start,
    first, last, closed, weights, count, size,
    position, rotation, distance, xy, whitening, held, free_along, unsettled, mask, image_slot, image_side,
    curve_slot, curve_side, across, along, kept,
):  # fmt: skip
    """Right-hand sides of the windows of a chunk alone; parameters as of :func:`chunk_sums`."""
    width = size + 3 * count
    rows, sums = np.empty((1, width)), np.empty(width)
    q, p, found, basis = np.empty((4, 3)), np.empty(3), np.empty(6), np.empty(count)
    for g in range(first_window, last_window):
        i, c = image[g], curve[g]
        begin, end = segment_start[c], segment_start[c + 1] - 1
        sums[:] = 0.0
        present = -1
        for k in range(starts[g], starts[g + 1]):
            n = points[k]
            u = wrapped(location[n], first[c], last[c]) if closed[c] else location[n]
            s = present if present >= 0 and left[present] <= u < left[present] + length[present] else -1
            if s < 0:
                s = segment_of(u, left, begin, end)
            at = (u - left[s]) / length[s]
            if s != present:
                photo_segment(polynomials, s, position, rotation, i, distance[i], q)
                present = s
            if not _directions(q, at, whitening, xy, n, p, found):
                return False
            x, y, b0, b1 = found[0], found[1], found[2], found[3]
            for j in range(count):
                basis[j] = weights[s, 0, j] + at * (
                    weights[s, 1, j] + at * (weights[s, 2, j] + at * weights[s, 3, j])
                )
            _project(-b1, b0, p, x, y, basis, rotation, i, distance[i], whitening, n, size, count, rows, 0)
            for a in range(width):
                sums[a] += found[4] * rows[0, a]
            across[n], along[n] = found[4], found[5]
            stays = free_along[k] and (held[n] or abs(found[5]) > unsettled)
            kept[n] = stays
            if stays:
                _project(b0, b1, p, x, y, basis, rotation, i, distance[i], whitening, n, size, count, rows, 0)
                for a in range(width):
                    sums[a] += found[5] * rows[0, a]
        local = g - first_window
        if len(mask):
            for a in range(width):
                sums[a] *= mask[local, a]
        for a in range(size):
            image_side[image_slot[local], a] -= sums[a]
        for a in range(3 * count):
            curve_side[curve_slot[local], a] -= sums[size + a]
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _take_out(mask, window):
    """Rows and columns of removed unknowns times 0."""
    width = len(mask)
    for a in range(width):
        for b in range(a, width):
            window[a, b] *= mask[a] * mask[b]
        window[a, width] *= mask[a]


@njit(cache=True, nogil=True, error_model="numpy")
def _store(window, local, spans, target, alone, values, shared):
    """Add the parts of a window to their targets."""
    for part in range(len(spans)):
        out = values if alone[part] else shared
        place, columns = target[part, local], spans[part, 3] - spans[part, 2]
        first, left = spans[part, 0], spans[part, 2]
        for a in range(spans[part, 1] - first):
            if first == left:
                for b in range(a):
                    out[place + b] += window[left + b, first + a]
                for b in range(a, columns):
                    out[place + b] += window[first + a, left + b]
            else:
                for b in range(columns):
                    out[place + b] += window[first + a, left + b]
            place += columns
