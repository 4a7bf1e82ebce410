"""The values of all curves that people give and read, value_k = sum_j m_kj P_j, and their cofactors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from splinebba_cli.core.curves.curve_set import CurveSet
from splinebba_cli.core.network import BoolArray, FloatArray, IntArray
from splinebba_cli.core.quality.cofactors import Cofactors

CHUNK = 50_000  # values at once


@dataclass(frozen=True)
class CurveValues:
    """Rows of the values of all curves, one curve after another."""

    bounds: IntArray  # (nc + 1,) values of a curve
    columns: IntArray  # (K, w) coefficients
    weights: FloatArray  # (K, w)
    is_position: BoolArray  # (K,)

    @classmethod
    def of(cls, curves: CurveSet) -> CurveValues:
        """Of all curves, narrower rows padded with weight 0."""
        bases = curves.bases
        bounds = np.concatenate(
            [[0], np.cumsum([len(basis.value_columns) for basis in bases], dtype=np.int64)]
        )
        columns = np.zeros((int(bounds[-1]), curves.support), dtype=np.int64)
        weights = np.zeros(columns.shape)
        widths = np.array([basis.value_columns.shape[1] for basis in bases], dtype=np.int64)
        for width in np.unique(widths).tolist():
            numbers = np.flatnonzero(widths == width)
            own = [bases[k] for k in numbers.tolist()]
            count = np.diff(bounds)[numbers]
            rows = np.arange(int(count.sum())) + np.repeat(
                bounds[numbers] - (np.cumsum(count) - count), count
            )
            start = np.repeat(curves.coefficient_start[numbers], count)
            place = np.concatenate([basis.value_columns for basis in own]) + start[:, None]
            columns[rows, :width], columns[rows, width:] = place, place[:, -1:]
            weights[rows, :width] = np.concatenate([basis.value_weights for basis in own])
        position = np.concatenate([np.zeros(0, dtype=bool), *(basis.value_is_position for basis in bases)])
        return cls(bounds.astype(np.int64), columns, weights, position)

    @cached_property
    def width(self) -> int:
        """Columns up to the last one that has a weight."""
        used = np.flatnonzero(self.weights.any(axis=0))
        return int(used[-1]) + 1 if len(used) else 0

    def at(self, coefficients: FloatArray) -> FloatArray:
        """Values (K, 3) of coefficients (C, 3)."""
        return np.asarray(np.matmul(self.weights[:, None, :], coefficients[self.columns])[:, 0])

    def cofactors(self, cofactors: Cofactors) -> FloatArray:
        """Cofactors of every value, (K, 3, 3)."""
        out, width = np.zeros((len(self.columns), 3, 3)), self.width
        for begin in range(0, len(out), CHUNK):
            own = slice(begin, begin + CHUNK)
            columns, weights = self.columns[own, :width], self.weights[own, :width]
            blocks = cofactors.coefficient_windows(columns).reshape(-1, width, 3, width, 3)
            out[own] = weighted(weights, blocks)
        return out


def weighted(weights: FloatArray, blocks: FloatArray) -> FloatArray:
    """sum_jk N_j Q_jk N_k of weights (n, w) and blocks (n, w, 3, w, 3), (n, 3, 3)."""
    count, width = weights.shape
    half = np.matmul(weights[:, None, :], blocks.reshape(count, width, 9 * width))
    return np.asarray(np.matmul(weights[:, None, None, :], half.reshape(count, 3, width, 3))[:, :, 0, :])
