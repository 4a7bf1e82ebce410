"""A curve segment in the frame of a photo, compiled; see :mod:`photo_polynomials`."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def photo_segment(polynomials, segment, position, rotation, image, distance, out):
    """Coefficients q_0 .. q_3 (4, 3) of a segment as an image sees it, u and v times -c, into `out`."""
    for k in range(4):
        x, y, z = polynomials[segment, k, 0], polynomials[segment, k, 1], polynomials[segment, k, 2]
        if k == 0:
            x, y, z = x - position[image, 0], y - position[image, 1], z - position[image, 2]
        out[k, 0] = -distance * (
            rotation[image, 0, 0] * x + rotation[image, 1, 0] * y + rotation[image, 2, 0] * z
        )
        out[k, 1] = -distance * (
            rotation[image, 0, 1] * x + rotation[image, 1, 1] * y + rotation[image, 2, 1] * z
        )
        out[k, 2] = rotation[image, 0, 2] * x + rotation[image, 1, 2] * y + rotation[image, 2, 2] * z


@njit(cache=True, nogil=True, error_model="numpy")
def segment_of(u, left, begin, end):
    """The last of the segments begin .. end that starts at or before u, else the first."""
    while begin < end:
        middle = (begin + end + 1) // 2
        if u >= left[middle]:
            begin = middle
        else:
            end = middle - 1
    return begin


@njit(cache=True, nogil=True, error_model="numpy")
def wrapped(u, first, last):
    """A location of a closed curve brought into its domain."""
    if first <= u < last:
        return u
    return first + (u - first) % (last - first)
