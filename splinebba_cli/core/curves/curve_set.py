"""All curves of a network as one: concatenated tables, evaluated for many curves at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from splinebba_cli.core.curves.basis import CurveBasis, power_row
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class CurveSet:
    """Concatenated tables; segments and coefficients are numbered through all curves."""

    bases: tuple[CurveBasis, ...]
    coefficient_start: IntArray  # (nc + 1,)
    segment_start: IntArray  # (nc + 1,)
    power: FloatArray  # (S, 4, w)
    columns: IntArray  # (S, w) coefficient numbers
    left: FloatArray  # (S,) parameter at the start of the segment
    length: FloatArray  # (S,)
    first: FloatArray  # (nc,) domain
    last: FloatArray  # (nc,)
    closed: BoolArray  # (nc,)
    has_location: BoolArray  # (nc,)
    _keys: FloatArray  # (S,) curve number + relative parameter of the segment's start

    @classmethod
    def of(cls, bases: Sequence[CurveBasis]) -> CurveSet:
        """Concatenate the tables of all curves; narrower supports are padded with weight 0."""
        support = max((b.support for b in bases), default=4)
        coefficient_start = _offsets([b.coefficient_count for b in bases])
        segment_start = _offsets([b.segment_count for b in bases])
        total = int(segment_start[-1])
        power, columns = np.zeros((total, 4, support)), np.zeros((total, support), dtype=np.int64)
        left, length, keys = np.zeros(total), np.zeros(total), np.zeros(total)
        for number, basis in enumerate(bases):
            rows = slice(int(segment_start[number]), int(segment_start[number + 1]))
            power[rows, :, : basis.support] = basis.power
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

    def weights(self, segment: IntArray, t: FloatArray, order: int = 0) -> FloatArray:
        """Basis values, or derivatives d/du of the given order, (n, w)."""
        weights = np.matmul(power_row(t, order)[:, None, :], self.power[segment])[:, 0, :]
        return np.asarray(weights / self.length[segment, None] ** order if order else weights)

    def segment_polynomials(self, coefficients: FloatArray) -> FloatArray:
        """Power form of every segment, X = sum_k a_k t^k, (S, 4, 3): Lee's coefficients."""
        return np.asarray(np.matmul(self.power, coefficients[self.columns]))

    def evaluate(
        self, coefficients: FloatArray, curve: IntArray, u: FloatArray, orders: Sequence[int] = (0,)
    ) -> list[FloatArray]:
        """Curve points or derivatives d/du at locations, one (n, 3) array per order."""
        segment, t = self.locate(curve, u)
        local = coefficients[self.columns[segment]]
        return [np.matmul(self.weights(segment, t, order)[:, None, :], local)[:, 0, :] for order in orders]


def _offsets(counts: Sequence[int]) -> IntArray:
    return np.concatenate([[0], np.cumsum(np.asarray(counts, dtype=np.int64))]).astype(np.int64)
