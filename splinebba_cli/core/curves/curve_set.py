"""All curves of a network as one: concatenated tables, evaluated for many curves at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.curves.basis import MAX_POWER, CurveBasis, harmonic_row, power_row
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class CurveSet:
    """Concatenated tables; segments and coefficients are numbered through all curves."""

    bases: tuple[CurveBasis, ...]
    coefficient_start: IntArray  # (nc + 1,)
    segment_start: IntArray  # (nc + 1,)
    power: FloatArray  # (S, K, w); K = 4 without trigonometric segments of higher order
    columns: IntArray  # (S, w) coefficient numbers
    left: FloatArray  # (S,) parameter at the start of the segment
    length: FloatArray  # (S,)
    first: FloatArray  # (nc,) domain
    last: FloatArray  # (nc,)
    closed: BoolArray  # (nc,)
    has_location: BoolArray  # (nc,)
    trigonometric: BoolArray  # (S,) whose elementary functions are 1, cos u, sin u, ...
    _keys: FloatArray  # (S,) curve number + relative parameter of the segment's start

    @classmethod
    def of(cls, bases: Sequence[CurveBasis]) -> CurveSet:
        """Concatenate the tables of all curves; narrower supports are padded with weight 0."""
        support = max((b.support for b in bases), default=4)
        coefficient_start = _offsets([b.coefficient_count for b in bases])
        segment_start = _offsets([b.segment_count for b in bases])
        total = int(segment_start[-1])
        functions = max([MAX_POWER, *(b.power.shape[1] for b in bases)])
        power, columns = np.zeros((total, functions, support)), np.zeros((total, support), dtype=np.int64)
        left, length, keys = np.zeros(total), np.zeros(total), np.zeros(total)
        for number, basis in enumerate(bases):
            rows = slice(int(segment_start[number]), int(segment_start[number + 1]))
            power[rows, : basis.power.shape[1], : basis.support] = basis.power
            columns[rows] = basis.columns[:, :1] + coefficient_start[number]
            columns[rows, : basis.support] = basis.columns + coefficient_start[number]
            breaks = basis.break_points
            left[rows], length[rows] = breaks[:-1], np.diff(breaks)
            keys[rows] = number + (breaks[:-1] - breaks[0]) / (breaks[-1] - breaks[0])
        return cls(
            bases=tuple(bases),
            coefficient_start=coefficient_start,
            segment_start=segment_start,
            power=power,
            columns=columns,
            left=left,
            length=length,
            first=np.array([b.break_points[0] for b in bases]),
            last=np.array([b.break_points[-1] for b in bases]),
            closed=np.array([b.closed for b in bases], dtype=bool),
            has_location=np.array([b.has_location for b in bases], dtype=bool),
            trigonometric=np.repeat([b.trigonometric for b in bases], np.diff(segment_start)).astype(bool),
            _keys=keys,
        )

    @property
    def support(self) -> int:
        """Number of coefficients that one location touches."""
        return int(self.power.shape[2])

    @property
    def coefficient_count(self) -> int:
        """Number of coefficients of all curves."""
        return int(self.coefficient_start[-1])

    def wrap(self, curve: IntArray, u: FloatArray) -> FloatArray:
        """Locations of closed curves brought into their domain."""
        if not self.any_closed:
            return u
        period = self.last[curve] - self.first[curve]
        return np.where(self.closed[curve], self.first[curve] + np.mod(u - self.first[curve], period), u)

    def locate(self, curve: IntArray, u: FloatArray) -> tuple[IntArray, FloatArray]:
        """Segment numbers and t of locations; open curves extend their end segments beyond [0, 1]."""
        wrapped = self.wrap(curve, u)
        first, last = self.first[curve], self.last[curve]
        relative = np.clip((wrapped - first) / (last - first), 0.0, 1.0 - 1e-12)
        segment = np.searchsorted(self._keys, curve + relative, side="right") - 1
        segment = np.clip(segment, self.segment_start[curve], self.segment_start[curve + 1] - 1)
        return segment, (wrapped - self.left[segment]) / self.length[segment]

    @cached_property
    def owner(self) -> IntArray:
        """Curve of every segment, (S,)."""
        return np.repeat(np.arange(len(self.bases)), np.diff(self.segment_start))

    @cached_property
    def shaped(self) -> tuple[int, ...]:
        """Curves with shape conditions."""
        return tuple(k for k, basis in enumerate(self.bases) if len(basis.shape_forms))

    @cached_property
    def any_closed(self) -> bool:
        """Whether any curve is closed."""
        return bool(self.closed.any())

    @cached_property
    def any_trigonometric(self) -> bool:
        """Whether any segment has other elementary functions than powers."""
        return bool(self.trigonometric.any())

    def weights(self, segment: IntArray, t: FloatArray, order: int = 0) -> FloatArray:
        """Basis values, or derivatives d/du of the given order, (n, w)."""
        if self.any_trigonometric:
            row = self._elementary(segment, t, order)
            return np.asarray(np.matmul(row[:, None, :], self.power[segment])[:, 0, :])
        weights = np.matmul(power_row(t, order)[:, None, :], self.power[segment])[:, 0, :]
        return np.asarray(weights / self.length[segment, None] ** order if order else weights)

    def _elementary(self, segment: IntArray, t: FloatArray, order: int) -> FloatArray:
        """Elementary functions or their derivatives d/du where segments of both kinds occur, (n, K)."""
        count, length = self.power.shape[1], self.length[segment]
        row = np.zeros((len(t), count))
        row[:, :MAX_POWER] = power_row(t, order) / length[:, None] ** order
        turning = np.flatnonzero(self.trigonometric[segment])
        u = self.left[segment[turning]] + t[turning] * length[turning]
        row[turning] = harmonic_row(u, order, count + 1 - count % 2)[:, :count]
        return row

    def segment_polynomials(self, coefficients: FloatArray) -> FloatArray:
        """Coefficients of the elementary functions of every segment, X = sum_k e_k a_k, (S, K, 3): Lee's a, b, c."""
        return np.asarray(np.matmul(self.power, coefficients[self.columns]))

    def derivatives(
        self, polynomials: FloatArray, segment: IntArray, t: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Curve points and their first and second derivative d/du, (n, 3) each, by Horner's scheme.

        Parameters
        ----------
        polynomials : (S, K, 3) of :meth:`segment_polynomials`
        """
        a, s, length = polynomials[segment], t[:, None], self.length[segment]
        value = a[:, 0] + s * (a[:, 1] + s * (a[:, 2] + s * a[:, 3]))
        first = (a[:, 1] + s * (2.0 * a[:, 2] + 3.0 * s * a[:, 3])) / length[:, None]
        second = (2.0 * a[:, 2] + 6.0 * s * a[:, 3]) / (length * length)[:, None]
        if self.any_trigonometric:
            turning = np.flatnonzero(self.trigonometric[segment])
            own, place = segment[turning], t[turning]
            for order, target in enumerate((value, first, second)):
                row = self._elementary(own, place, order)
                target[turning] = np.matmul(row[:, None, :], a[turning])[:, 0, :]
        return value, first, second

    def evaluate(
        self, coefficients: FloatArray, curve: IntArray, u: FloatArray, orders: Sequence[int] = (0,)
    ) -> list[FloatArray]:
        """Curve points or derivatives d/du at locations, one (n, 3) array per order."""
        segment, t = self.locate(curve, u)
        local = coefficients[self.columns[segment]]
        return [np.matmul(self.weights(segment, t, order)[:, None, :], local)[:, 0, :] for order in orders]


def _offsets(counts: Sequence[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(np.asarray(counts, dtype=np.int64))]).astype(np.int64)
