"""A curve segment in the frame of a photo, compiled; see :mod:`photo_polynomials`."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def photo_segment(polynomial, position, rotation, distance, out):
    """Coefficients q_0 .. q_3 (4, 3) of a segment (4, 3) as an image sees it, u and v times -c, into `out`."""
    for k in range(4):
        x, y, z = polynomial[k, 0], polynomial[k, 1], polynomial[k, 2]
        if k == 0:
            x, y, z = x - position[0], y - position[1], z - position[2]
        out[k, 0] = -distance * (rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z)
        out[k, 1] = -distance * (rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z)
        out[k, 2] = rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z
