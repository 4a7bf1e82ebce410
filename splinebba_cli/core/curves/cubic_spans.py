"""All curves of a network as cubics, in Bernstein form: what hulls and foot points need, for every family.

A segment of powers is one span, exactly.  A segment of another family is divided into spans of equal u, on each of
which Hermite's cubic takes values and derivatives of its ends; it differs from X by no more than

    h^4 / 384 max |X''''|,    X'''' of sum_k (A_k cos ku + B_k sin ku) is at most sum_k k^4 (|A_k|^2 + |B_k|^2)^(1/2)

With the segments of harmonics, of a quarter period of the highest, 16 spans keep this below 2.5e-7 of the sum of the
radii: places on a curve whose distances from a point differ by less are one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER
from splinebba_cli.core.curves.bernstein import from_powers
from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import FloatArray, IntArray

SPANS = 16  # of a segment that is not cubic, a power of two: t of their ends is exact


@dataclass(frozen=True)
class CubicSpans:
    """Spans of all segments, in the order of these."""

    segment: IntArray  # (n,)
    begin: FloatArray  # (n,) t
    width: FloatArray  # (n,) t
    points: FloatArray  # (4, 3, n) Bernstein coefficients, metres
    error: FloatArray  # (n,) metres, largest distance from the curve

    @classmethod
    def of(cls, curves: CurveSet, polynomials: FloatArray) -> CubicSpans:
        """Spans of the present segments.

        Parameters
        ----------
        polynomials : (S, K, 3) of :meth:`CurveSet.segment_polynomials`
        """
        count = np.where(curves.trigonometric, SPANS, 1)
        segment = np.repeat(np.arange(len(count)), count)
        width = 1.0 / count[segment]
        begin = (np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count)) * width
        points = from_powers(np.ascontiguousarray(polynomials[:, :MAX_POWER].transpose(1, 2, 0)))[
            :, :, segment
        ]
        error = np.zeros(len(segment))
        turning = np.flatnonzero(curves.trigonometric[segment])
        if len(turning):
            own = segment[turning]
            h = (width * curves.length[segment])[turning]
            ends = [
                curves.derivatives(polynomials, own, begin[turning] + part * width[turning])
                for part in (0.0, 1.0)
            ]
            (first, rise, _), (last, fall, _) = ends
            thirds = (first, first + rise * h[:, None] / 3.0, last - fall * h[:, None] / 3.0, last)
            points[:, :, turning] = np.stack(thirds).transpose(0, 2, 1)
            error[turning] = h**4 / 384.0 * _fourth_derivatives(polynomials)[own]
        return cls(segment, begin, width, points, error)


def _fourth_derivatives(harmonics: FloatArray) -> FloatArray:
    """Bounds of |X''''| of harmonics (S, K, 3), (S,); unused ones are 0."""
    square = np.sum(harmonics[:, 1:] ** 2, axis=2)
    if square.shape[1] % 2:
        square = np.concatenate([square, np.zeros((len(square), 1))], axis=1)
    radius = np.sqrt(square[:, 0::2] + square[:, 1::2])
    order = np.arange(1.0, radius.shape[1] + 1.0)
    return np.asarray(radius @ order**4)
