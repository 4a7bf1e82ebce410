"""Polynomials that vanish where the distance from a cubic segment is stationary.

In space, from a ray or a point: with n(t) the difference across the ray (two components) or to the point (three),

    d/dt |n|^2 / 2 = n . n'                                                                        degree 5

In the photo, x(t) = Q(t) / D(t), Q = c (u, v), D = -w > 0 in front of the camera.  From the measured point m, with
n = Q - m D,

    d/dt |n / D|^2 / 2 = n . e / D^3,    e = Q' D - Q D' = n' D - n D'                              degree 3 + 4 = 7

because the leading terms of e cancel.  e is D^2 times the velocity of the image of the curve and does not depend on m,
so that n . e = G(t) - m . H(t) with G = Q . e, H = D e: a table of three polynomials for a segment, and a few products
for every point measured near it.  For straight lines both degrees fall to 1: n . n1, and e is constant.

All in Bernstein form (bernstein.py); the last axis of arrays runs over segments or points.  Lee (2008), 4.9, with R in
place of R': the ray has the direction R (x, y, -c)'.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from splinebba_cli.core.network import FloatArray, IntArray


def stationary_in_space(n: FloatArray) -> FloatArray:
    """n . n' of cubics n, Bernstein coefficients (6, k).

    Parameters
    ----------
    n : (4, q, k) float, Bernstein coefficients of q components
    """
    return _scalar_product(n, 3.0 * np.diff(n, axis=0))


def velocity_numerators(points: FloatArray, depth: FloatArray) -> FloatArray:
    """e = Q' D - Q D' of rational cubics, Bernstein coefficients (5, q, k).

    Parameters
    ----------
    points : (4, q, k) float, Bernstein coefficients of Q
    depth : (4, k) float, of D
    """
    out = np.zeros((5, *points.shape[1:]))
    for i in range(4):
        for j in range(i + 1, 4):
            weight = comb(3, i) * comb(3, j) * (j - i) / comb(4, i + j - 1)
            out[i + j - 1] += weight * (points[j] * depth[i, None] - points[i] * depth[j, None])
    return out


@dataclass(frozen=True)
class PhotoStationarity:
    """G and H of segments as images see them."""

    table: FloatArray  # (3, 8, k): G, H_x, H_y

    @classmethod
    def of(cls, points: FloatArray, depth: FloatArray) -> PhotoStationarity:
        """From Bernstein coefficients of Q (4, 2, k), mm times the unit of D (4, k)."""
        e = velocity_numerators(points, depth)
        table = [
            _scalar_product(points, e),
            _scalar_product(depth[:, None], e[:, :1]),
            _scalar_product(depth[:, None], e[:, 1:]),
        ]
        return cls(np.stack(table))

    def at(self, column: IntArray, measured: FloatArray) -> FloatArray:
        """n . e for points near segments, Bernstein coefficients (8, n).

        Parameters
        ----------
        column : (n,) segment of every point
        measured : (2, n) mm
        """
        g, hx, hy = np.take(self.table, column, axis=2)
        hx *= measured[0]
        hy *= measured[1]
        g -= hx
        g -= hy
        return np.asarray(g)


def foot_on_line_in_space(start: FloatArray, along: FloatArray) -> FloatArray:
    """t of the place of lines n0 + t n1 that is nearest to the ray or point, (k,); NaN where n1 = 0.

    Parameters
    ----------
    start, along : (q, k) n0 and n1, differences across the ray (q = 2) or to the point (q = 3)
    """
    with np.errstate(all="ignore"):
        return np.asarray(-(start * along).sum(axis=0) / (along * along).sum(axis=0))


def foot_on_line_in_photo(start: FloatArray, along: FloatArray, depth: FloatArray) -> FloatArray:
    """t of the place of lines seen in photos that is nearest to the measured point, (k,); NaN where e = 0.

    Parameters
    ----------
    start, along : (2, k) n0 and n1, n = n0 + t n1 = Q - m D
    depth : (2, k) D0 and D1
    """
    e = along * depth[0] - start * depth[1]
    with np.errstate(all="ignore"):
        return np.asarray(-(start * e).sum(axis=0) / (along * e).sum(axis=0))


def _scalar_product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of polynomials in Bernstein form, summed over components, (da + db + 1, k).

    Parameters
    ----------
    a, b : (da + 1, q, k), (db + 1, q, k)
    """
    first, second = len(a) - 1, len(b) - 1
    out = np.zeros((first + second + 1, a.shape[2]))
    for i in range(first + 1):
        for j in range(second + 1):
            weight = comb(first, i) * comb(second, j) / comb(first + second, i + j)
            out[i + j] += weight * (a[i] * b[j]).sum(axis=0)
    return out
